#pragma once
// What a user may ask of a simulation: plain structs with a default, a unit and the effect of each field.
// They hold no file paths and no pictures; src/pipeline/scene_file/scene_file.h fills them from a TOML file.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth {

/// A scene that cannot be simulated. `key` is the dotted place in the scene ("cloth[0].fabric.density").
class SceneError : public std::runtime_error {
  public:
    SceneError(std::string key_path, const std::string& message)
        : std::runtime_error(message), key(std::move(key_path)) {}
    std::string key;
};

/// How a sheet resists stretch and shear in its plane.
enum class MembraneKind {
    corotational,         ///< the assignment's, μ Σ (s_i - 1)² + λ/2 (s_0 + s_1 - 2)²
    st_venant_kirchhoff,  ///< quadratic in the Green strain; the one that knows warp and weft
    neo_hookean,          ///< stable neo-Hookean; stays finite where a triangle is squeezed flat
};

/// How a sheet resists bending.
enum class BendingKind {
    quadratic,  ///< constant Hessian; the rest shape counts as flat
    hinges,     ///< by the angles between triangles; curved rest shapes and creases
};

/// Material of a sheet. Along the warp, across it (the weft) and, for bending, at 45 degrees (the bias).
/// One of numbers alone begins with these; a cloth that says nothing is of default_fabric().
struct Fabric {
    std::string name;         ///< the entry of the fabric table that it came from, if any
    double density = 0.15;    ///< mass per area of the sheet [kg/m²]
    double thickness = 1e-3;  ///< multiplies the membrane energy [m]
    MembraneKind membrane = MembraneKind::corotational;
    double young_modulus = 1e5;  ///< [Pa]; used with poisson_ratio unless mu and lambda are given
    double poisson_ratio = 0.3;  ///< in (-1, 1); plane stress: λ = Eν/(1-ν²), μ = E/(2(1+ν))
    /// st_venant_kirchhoff: young_modulus is the warp's, this is the weft's [Pa]; poisson_ratio is the weft's
    /// shortening over the warp's stretch, so ν² < E_warp/E_weft.
    std::optional<double> young_weft;
    std::optional<double> shear_modulus;  ///< st_venant_kirchhoff: of warp against weft [Pa]; else E/(2(1+ν))
    std::optional<double> mu;             ///< shear modulus handed to the energy as it is [Pa]
    std::optional<double> lambda;         ///< second modulus handed to the energy as it is [Pa]
    /// Principal stretch that no triangle reaches, above 1; the resistance rises from half of the way on.
    std::optional<double> strain_limit;
    BendingKind bending_model = BendingKind::quadratic;
    double bending = 0.0;  ///< bending rigidity D along the warp [N m]; 0: none, as in the assignment
    std::optional<double> bending_weft;  ///< [N m]; else as along the warp
    std::optional<double> bending_bias;  ///< [N m]; else such that H = √(warp · weft), see bending_rigidity()
    /// hinges: curvature beyond which a fold stays, in part [1/m]; none: elastic.
    std::optional<double> yield_curvature;
    double membrane_damping = 0.0;  ///< viscous stress = this time × stiffness × strain rate [s]
    double bending_damping = 0.0;   ///< viscous moment = this time × rigidity × curvature rate [s]
    double friction = 0.0;          ///< Coulomb coefficient of the fabric
};

/// Cotton, as fabrics.h has it.
Fabric default_fabric();

/// How a grid's squares are cut in two.
enum class Diagonals {
    uniform,      ///< all in one direction, as the assignment's mesh
    mirrored,     ///< all in the other direction
    alternating,  ///< changing from square to square; twists twice as stiffly as it should (bending.h)
};

/// A flat rectangle in the plane z = 0, centred at the origin, normal +z.
struct Grid {
    Vec2 size{1.0, 1.0};                    ///< width along x, height along y [m]
    std::array<int, 2> resolution{20, 20};  ///< vertices along x and along y, each at least 2
    Diagonals diagonals = Diagonals::uniform;
};

/// A flat disc in the plane z = 0, centred at the origin, normal +z: a vertex in the middle and rings of 6,
/// 12, 18 … vertices around it.
struct Disc {
    double radius = 0.15;  ///< [m]
    int rings = 20;
};

/// Triangles that a file gives a name: those of a material, a group or an object.
struct MeshPart {
    std::string name;
    std::vector<int> triangles;  ///< sorted
};

/// Vertices and triangles as a file gave them, of clothes mended (mesh_repair.h); their order is kept.
struct MeshData {
    Points positions;     ///< shape (n, 3), in the unit that the cloth or collider names
    Triangles triangles;  ///< shape (m, 3)
    /// Texture coordinates of corner k of triangle t in row 3t + k, shape (3m, 2); NaN where the file has
    /// none for it, no rows where it has none at all.
    TexturePoints uv{};
    std::vector<MeshPart> parts{};  ///< sorted by name
    /// Of a sewing pattern: texture coordinates are metres, and rows of vertices are to be sewn together.
    bool pattern = false;
    std::vector<std::array<std::vector<int>, 2>> stitches{};
};

/// What a cloth of a mesh is like at rest.
enum class RestShape {
    mesh,  ///< as the mesh stands
    uv,    ///< each triangle as its texture coordinates have it, as a pattern is cut
};

/// Where a mesh's vertices are over time, as a file gave it.
struct MeshCache {
    std::vector<Points> frames;  ///< at least one; shape (n, 3), in the unit that the collider names
    std::vector<double> times;   ///< of each, rising [s]; empty: the file does not tell
    Triangles triangles;         ///< shape (m, 3); no rows: the file has none
};

/// What the numbers in a mesh file mean.
enum class LengthUnit { metre, centimetre, millimetre, inch, foot };

/// [m]
constexpr double length_of(LengthUnit unit) {
    switch (unit) {
        case LengthUnit::centimetre:
            return 0.01;
        case LengthUnit::millimetre:
            return 0.001;
        case LengthUnit::inch:
            return 0.0254;
        case LengthUnit::foot:
            return 0.3048;
        default:
            return 1.0;
    }
}

/// Applied to a rest shape in the order scale, rotate, translate.
struct Transform {
    double scale = 1.0;
    Vec3 rotate = Vec3::Zero();     ///< turns about the fixed x, then y, then z axis [degree]
    Vec3 translate = Vec3::Zero();  ///< [m]
};

/// One sheet: a rest shape and, apart from it, a start pose and velocity.
struct ClothDesc {
    std::string name = "cloth";
    Grid grid;                     ///< rest shape, unless `disc` or `mesh` is given
    std::optional<Disc> disc;      ///< rest shape
    std::optional<MeshData> mesh;  ///< rest shape; may be curved
    /// Of a sewing pattern: usual length of the triangles' edges [m].
    std::optional<double> edge_length;
    RestShape rest = RestShape::mesh;
    /// Of RestShape::uv: a unit of texture coordinates [m]; default: natural_uv_scale(), rest_shape.h.
    std::optional<double> uv_scale;
    std::optional<Points>
        pose;  ///< start positions before `transform`, shape (n, 3), in `units`; default: rest shape
    LengthUnit units = LengthUnit::metre;  ///< of the coordinates in `mesh` and `pose`
    bool weld = true;                      ///< of a mesh from a file: vertices at one place become one
    Transform transform;                   ///< moves rest shape (or pose) to the start
    Vec3 velocity = Vec3::Zero();          ///< start velocity of the free vertices [m/s]
    /// Smooth out-of-plane start offset z += amplitude sin(pi (x-x0)/w) sin(pi (y-y0)/h) over the rest
    /// shape's bounding box, before `transform` [m]; gives a buckling sheet a definite side.
    double bump = 0.0;
    Vec3 warp = Vec3::UnitY();  ///< direction of the warp on the rest shape, any length but zero
    /// Of `barrier`: other things stay half of this away from the sheet [m]; default: usual_length(1e-3).
    std::optional<double> contact_thickness;
    Fabric fabric = default_fabric();

    /// The grid where it is the rest shape, else null.
    const Grid* rest_grid() const { return disc || mesh ? nullptr : &grid; }
};

/// A part of a cloth's mesh that is of a fabric of its own.
struct PartDesc {
    int cloth = 0;
    std::string name;                  ///< of a MeshPart
    Fabric fabric = default_fabric();  ///< but for friction, which is the cloth's
};

enum class Shape { sphere, plane, box, capsule, cylinder, mesh };

/// Shapes of one curvature everywhere: the velocity filter and penalty contact know these alone.
constexpr bool has_one_curvature(Shape shape) {
    return shape == Shape::sphere || shape == Shape::plane;
}

/// Where a moving thing stands at a time: turned about a centre, then shifted.
struct MotionKey {
    double time = 0.0;              ///< [s]
    Vec3 translate = Vec3::Zero();  ///< [m]
    Vec3 rotate = Vec3::Zero();     ///< turns about the fixed x, then y, then z axis [degree]
};

/// A body that cloth meets. The velocity filter and penalty contact know spheres and planes at rest.
struct ColliderDesc {
    std::string name = "collider";
    Shape shape = Shape::sphere;
    Vec3 center = Vec3::Zero();    ///< where the shape's origin stands; plane: a point on it [m]
    Vec3 normal = Vec3::UnitY();   ///< plane: outward normal, any length but zero
    double radius = 0.25;          ///< sphere, capsule, cylinder: radius as drawn [m]
    double height = 0.5;           ///< capsule, cylinder: length of the axis, along y before `rotate` [m]
    Vec3 size{0.5, 0.5, 0.5};      ///< box: edge lengths [m]
    std::optional<MeshData> mesh;  ///< mesh: open or closed, any triangles
    /// mesh: its vertices over time, linear between frames, instead of those in `mesh`.
    std::shared_ptr<const MeshCache> cache;
    double cache_start = 0.0;              ///< when the cache's first frame stands; it stands before, too [s]
    double cache_speed = 1.0;              ///< of the cache's time against the run's
    bool cache_loop = false;               ///< after the last frame comes the first; else the last one stays
    std::optional<double> cache_rate;      ///< frames per second, instead of the cache's own times
    LengthUnit units = LengthUnit::metre;  ///< mesh: of its coordinates
    double scale = 1.0;                    ///< mesh: applied before `rotate`
    Vec3 rotate = Vec3::Zero();   ///< box, capsule, cylinder, mesh: about the fixed x, y, z axes [degree]
    std::vector<MotionKey> path;  ///< moves the body, turning it about `center`; empty: at rest
    Vec3 spin = Vec3::Zero();     ///< steady turn about `center`, before `path`'s: axis times rate [degree/s]
    double contact_offset = 0.0;  ///< contact begins this far outside the drawn surface [m]
    std::optional<double> contact_radius;  ///< sphere: contact begins this far from the centre instead [m]
    double friction = 0.35;  ///< Coulomb coefficient; `barrier` takes the geometric mean with the fabric's
    bool enabled = true;     ///< whether it is on at the start
    bool drawn = true;
    bool touchable = true;  ///< false: only drawn, cloth passes through
};

/// Some of a cloth's vertices; exactly one selection is given. Coordinates are those of the start pose.
struct VertexSelection {
    std::vector<int> vertices;               ///< indices into the cloth's vertices
    std::optional<std::array<Vec3, 2>> box;  ///< all vertices in the closed box [m]
    std::optional<Vec3> nearest;             ///< the vertex nearest this point [m]
    std::optional<std::string> greatest;     ///< "x", "y", "z", "-x", …: within tolerance of the extreme
    std::optional<std::string> edge;         ///< of a grid: "left", "right", "bottom", "top"
    std::optional<std::string> part;         ///< of a mesh: the corners of a MeshPart
    double tolerance = 1e-3;                 ///< for `greatest` [m]
};

/// Holds vertices where they start, or moves them along keys or with a collider.
struct PinDesc : VertexSelection {
    int cloth = 0;
    /// Index into Scene::colliders: the vertices go where it carries them, as a waistband does.
    std::optional<int> collider;
    std::vector<MotionKey> path;  ///< linear between keys, constant outside; empty: at rest
    std::optional<Vec3> center;   ///< of the turns [m]; default: the mean of the vertices held
    std::optional<double> until;  ///< lets go at this time [s]
};

/// Sews two rows of vertices together: springs whose rest length shrinks from the start distance to zero.
struct SeamDesc {
    /// Vertices in the order listed, or in that of the cloth's indices.
    struct Side : VertexSelection {
        int cloth = 0;
    };
    std::array<Side, 2> sides;  ///< as many vertices on both
    bool reverse = false;       ///< the second side in the opposite order
    double begin = 0.0;         ///< closing starts [s]
    double close_time = 1.0;    ///< and takes this long [s]
    double stiffness = 1e3;     ///< of each spring [N/m]
};

/// The air that a cloth moves in: still, or a wind with gusts.
struct AirDesc {
    double density = 1.2;      ///< [kg/m³]
    double drag = 0.0;         ///< coefficient C_D of a triangle's projected area; 0: no air
    double lift = 0.0;         ///< coefficient C_L, at most C_D
    Vec3 wind = Vec3::Zero();  ///< mean [m/s]
    double gusts = 0.0;        ///< root mean square of each gust component [m/s]
    double gust_length = 1.0;  ///< longest wave of the gusts [m]
    std::uint32_t seed = 1;    ///< of the gusts
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
    implicit_euler,           ///< first order, dissipative; minimises the incremental potential by Newton
    tr_bdf2,                  ///< second order, little dissipation: trapezoidal rule, then BDF2; two solves
    implicit_midpoint,        ///< second order, conserves momentum, no dissipation: ringing stays
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

/// Hessian of linearly_implicit_euler's one solve.
enum class LinearHessian {
    assignment,  ///< (dF/dq)ᵀ ψ'' (dF/dq), eigenvalues below 1e-6 set to 1e-3
    projected,   ///< exact, projected to positive semi-definite in closed form
};

/// How cloth meets colliders.
enum class ContactKind {
    velocity_filter,  ///< the assignment's: filters velocities, leaves positions alone
    penalty,          ///< stiff layer of contact_offset around each collider, solved with the step
    barrier,          ///< nothing ever passes through anything: cloth, itself and colliders, with friction
};

/// How far each step of an implicit integrator is solved.
enum class Accuracy {
    draft,      ///< previews: a tenth of the cloth's own speed, or 0.3 m/s
    fine,       ///< shape, motion and energy as a solved step's, wrinkles chosen by chance
    reference,  ///< by the residual alone
};

/// When a solve ends: where the residual is no more than `tolerance` of the step's start, or after an
/// iteration that moves no vertex faster than `speed`, or than `share` of the cloth's own speed (root of the
/// mean square), once the forces left change no cloth's mean velocity by a hundredth of that.
struct StoppingLimits {
    double tolerance;
    double speed;  ///< [m/s]; 0, and no share: by the residual alone
    double share;
};

struct SimulationDesc {
    Vec3 gravity{0.0, -9.81, 0.0};  ///< [m/s²]
    double frame_rate = 60.0;       ///< frames per second of simulated time; frame k stands at k / frame_rate
    /// Largest step [s]; each frame is cut into the fewest equal steps that are no longer. Unless `substeps`.
    std::optional<double> time_step;
    std::optional<int> substeps;  ///< steps per frame, instead of time_step
    IntegratorKind integrator = IntegratorKind::implicit_euler;
    LinearHessian hessian = LinearHessian::assignment;  ///< of linearly_implicit_euler
    ContactKind contact = ContactKind::barrier;
    double contact_stiffness = 100.0;  ///< of `penalty`, per vertex [N/m]
    /// Friction is in full force above this speed [m/s]; default: 1e-3 for `penalty`, 1e-4 for `barrier`.
    std::optional<double> sliding_speed;
    /// Of `barrier`: gap at which repulsion begins [m]; default: usual_length(1e-3), of the cloths the least.
    std::optional<double> contact_activation;
    int newton_iterations = 100;  ///< most Newton iterations of one solve
    Accuracy accuracy = Accuracy::fine;
    /// In the place of `accuracy`: StoppingLimits::tolerance, 1e-6 where only the other is said;
    std::optional<double> newton_tolerance;
    /// and StoppingLimits::speed [m/s], 0 where only the other is said.
    std::optional<double> newton_speed;
    int retries = 8;  ///< times that a step which does not converge is halved before the run stops
    AirDesc air;

    /// What the fields above amount to.
    StoppingLimits stopping() const;
    /// Steps per frame that the fields above amount to.
    int steps_per_frame() const;
    /// Length of one step [s].
    double step_size() const { return 1.0 / (frame_rate * steps_per_frame()); }
};

struct Scene {
    std::string name;
    SimulationDesc simulation;
    std::vector<ClothDesc> cloths;
    std::vector<PartDesc> parts;
    std::vector<ColliderDesc> colliders;
    std::vector<PinDesc> pins;
    std::vector<SeamDesc> seams;
    std::vector<DragDesc> drags;
    std::vector<EventDesc> events;
};

/// Checks ranges and references; throws SceneError with the key, the value, the range and the unit.
void validate(const Scene& scene);

}  // namespace cloth
