#pragma once
// What a user may ask of a simulation: plain structs with a default, a unit and the effect of each field.
// They hold no file paths and no pictures; src/pipeline/scene_file.h fills them from a TOML file.

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/types.h"

namespace cloth {

/// A scene that cannot be simulated. `key` is the dotted place in the scene ("cloth[0].fabric.density").
class SceneError : public std::runtime_error {
  public:
    SceneError(std::string key_path, const std::string& message)
        : std::runtime_error(message), key(std::move(key_path)) {}
    std::string key;
};

/// Material of a sheet.
struct Fabric {
    double density = 0.15;         ///< mass per area of the sheet [kg/m²]
    double thickness = 1e-3;       ///< multiplies the membrane energy [m]
    double young_modulus = 1e5;    ///< [Pa]; used with poisson_ratio unless mu and lambda are given
    double poisson_ratio = 0.3;    ///< in (-1, 1); plane stress: λ = Eν/(1-ν²), μ = E/(2(1+ν))
    std::optional<double> mu;      ///< shear modulus handed to the energy as it is [Pa]
    std::optional<double> lambda;  ///< second modulus handed to the energy as it is [Pa]
    double bending = 0.0;          ///< bending rigidity D [N m]; 0: none, as in the assignment
};

/// How a grid's squares are cut in two.
enum class Diagonals {
    uniform,      ///< all in one direction, as the assignment's mesh
    alternating,  ///< direction changes from square to square: no preferred bias direction
};

/// A flat rectangle in the plane z = 0, centred at the origin, normal +z.
struct Grid {
    Vec2 size{1.0, 1.0};                    ///< width along x, height along y [m]
    std::array<int, 2> resolution{20, 20};  ///< vertices along x and along y, each at least 2
    Diagonals diagonals = Diagonals::alternating;
};

/// Vertices and triangles as a file gave them; their order is kept.
struct MeshData {
    Points positions;     ///< shape (n, 3) [m]
    Triangles triangles;  ///< shape (m, 3)
};

/// Applied to a rest shape in the order scale, rotate, translate.
struct Transform {
    double scale = 1.0;
    Vec3 rotate = Vec3::Zero();     ///< turns about the fixed x, then y, then z axis [degree]
    Vec3 translate = Vec3::Zero();  ///< [m]
};

/// One sheet: a rest shape and, apart from it, a start pose and velocity.
struct ClothDesc {
    std::string name = "cloth";
    Grid grid;                     ///< rest shape, unless `mesh` is given
    std::optional<MeshData> mesh;  ///< rest shape; may be curved
    std::optional<Points>
        pose;             ///< start positions before `transform`, shape (n, 3) [m]; default: rest shape
    Transform transform;  ///< moves rest shape (or pose) to the start
    Vec3 velocity = Vec3::Zero();  ///< start velocity of the free vertices [m/s]
    /// Smooth out-of-plane start offset z += amplitude sin(pi (x-x0)/w) sin(pi (y-y0)/h) over the rest
    /// shape's bounding box, before `transform` [m]; gives a buckling sheet a definite side.
    double bump = 0.0;
    Fabric fabric;
};

enum class Shape { sphere, plane };

/// A fixed body met by the velocity filter.
struct ColliderDesc {
    std::string name = "collider";
    Shape shape = Shape::sphere;
    Vec3 center = Vec3::Zero();            ///< sphere: centre; plane: a point on it [m]
    Vec3 normal = Vec3::UnitY();           ///< plane: outward normal, any length but zero
    double radius = 0.25;                  ///< sphere: radius as drawn [m]
    double contact_offset = 0.0;           ///< contact begins this far outside the drawn surface [m]
    std::optional<double> contact_radius;  ///< sphere: contact begins this far from the centre instead [m]
    double friction = 0.0;  ///< Coulomb coefficient of the velocity filter; 0 as in the assignment
    bool enabled = true;    ///< whether it is on at the start
    bool drawn = true;
};

/// Which vertices a pin holds; exactly one selection is given. Coordinates are those of the start pose.
struct PinDesc {
    int cloth = 0;
    std::vector<int> vertices;               ///< indices into the cloth's vertices
    std::optional<std::array<Vec3, 2>> box;  ///< all vertices in the closed box [m]
    std::optional<Vec3> nearest;             ///< the vertex nearest this point [m]
    std::optional<std::string> greatest;     ///< "x", "y", "z", "-x", …: within tolerance of the extreme
    double tolerance = 1e-3;                 ///< for `greatest` [m]
};

/// A recorded mouse drag. At the first key's time it picks vertices through the camera; until the last key's
/// time each picked vertex is pulled by a spring of rest length 0 towards the place where it was picked plus
/// the way that the pointer has gone since, measured in the plane of the picked point.
struct DragDesc {
    struct Key {
        double time;  ///< [s]
        Vec2 pixel;   ///< x to the right, y down from the top left corner of the viewport [pixel]
    };
    std::vector<Key> path;
    double radius = 0.1;                 ///< vertices this near the picked one are picked too [m]
    double stiffness = 1e5;              ///< of each spring [N/m]
    Vec2 viewport{1280, 720};            ///< the window the pixels refer to [pixel]
    Mat4 view = Mat4::Identity();        ///< world → camera, camera looks along -z
    Mat4 projection = Mat4::Identity();  ///< camera → clip, OpenGL convention
};

enum class IntegratorKind {
    linearly_implicit_euler,  ///< the assignment's: one linear solve with its Hessian
    implicit_euler,           ///< Newton's method with line search on the incremental potential
};

enum class Switch { on, off, toggle };

/// Something that changes at a time: the assignment's `c` key (a collider) or `n` key (the integrator).
struct EventDesc {
    double time = 0.0;                         ///< applies from the first step that starts at or after it [s]
    std::optional<int> collider;               ///< index into Scene::colliders
    Switch action = Switch::toggle;            ///< for a collider
    bool toggle_integrator = false;            ///< switch to the other integrator
    std::optional<IntegratorKind> integrator;  ///< switch to this one
};

/// Which Hessian an energy gives.
enum class HessianKind {
    assignment,  ///< (dF/dq)ᵀ ψ'' (dF/dq), eigenvalues below 1e-6 set to 1e-3
    projected,   ///< exact, projected to positive semi-definite in closed form
    exact,       ///< second derivative; may be indefinite
};

/// How cloth meets colliders.
enum class ContactKind {
    velocity_filter,  ///< the assignment's: filters velocities, leaves positions alone
    penalty,          ///< stiff layer of contact_offset around each collider, solved with the step
};

struct SimulationDesc {
    Vec3 gravity{0.0, -9.81, 0.0};  ///< [m/s²]
    double frame_rate = 60.0;       ///< frames per second of simulated time; frame k stands at k / frame_rate
    /// Largest step [s]; each frame is cut into the fewest equal steps that are no longer. Unless `substeps`.
    std::optional<double> time_step;
    std::optional<int> substeps;  ///< steps per frame, instead of time_step
    IntegratorKind integrator = IntegratorKind::linearly_implicit_euler;
    HessianKind hessian = HessianKind::assignment;  ///< of linearly_implicit_euler: assignment or projected
    ContactKind contact = ContactKind::velocity_filter;
    double contact_stiffness = 100.0;  ///< of `penalty`, per vertex [N/m]
    double sliding_speed = 1e-3;       ///< of `penalty`: friction is in full force above this speed [m/s]
    int newton_iterations = 50;        ///< most Newton iterations of one implicit Euler step
    double newton_tolerance = 1e-8;    ///< residual |g| / |g at the step's start| at which Newton stops

    /// Steps per frame that the fields above amount to.
    int steps_per_frame() const;
    /// Length of one step [s].
    double step_size() const { return 1.0 / (frame_rate * steps_per_frame()); }
};

struct Scene {
    std::string name;
    SimulationDesc simulation;
    std::vector<ClothDesc> cloths;
    std::vector<ColliderDesc> colliders;
    std::vector<PinDesc> pins;
    std::vector<DragDesc> drags;
    std::vector<EventDesc> events;
};

/// Checks ranges and references; throws SceneError with the key, the value, the range and the unit.
void validate(const Scene& scene);

}  // namespace cloth
