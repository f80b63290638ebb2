#pragma once
// Why a step does not get to its end: what stands in the way, and where.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth {

class ContactSet;
struct Model;
struct Pin;

/// Vertices and triangles are numbered within their cloth.
struct Obstacle {
    enum class Kind { contact, strain_limit };
    Kind kind = Kind::contact;
    int cloth = 0;
    int element = 0;            ///< of `contact` the cloth's vertex, else its triangle
    Vec3 place = Vec3::Zero();  ///< of it [m]
    double time = 0.0;          ///< that the step does not reach [s]
    bool certain = false;       ///< no way leads to where things are to be then: shorter steps do not help

    // ---- strain_limit
    double stretch = 1.0, limit = 0.0;
    bool asked = false;  ///< the stretch is what pins on their way ask for, else what there is

    // ---- contact
    std::vector<int> colliders;               ///< that the cloth meets there; two close on it
    std::optional<std::array<int, 2>> other;  ///< cloth that it meets, its vertex
    std::optional<int> pin;                   ///< that holds the vertex
    /// Between two colliders, or from where the pin holds the vertex to the collider, at `time`; and what
    /// cloth needs there [m]. Where `room` is less the end is certain.
    double room = 0.0, needed = 0.0;
};

/// What keeps pins and colliders, stuck on their way with the cloth at x, from their places: the tightest
/// contact, or the strain limit where `guess`, where all would have gone without it, is given. None where
/// neither is near. `contact`: null without barriers.
std::optional<Obstacle> obstacle_of_placing(const Model& model, const ContactSet* contact,
                                            const std::vector<Pin>& pins, const VecX& x, const VecX* guess);

/// The triangle nearest its strain limit at x; none where all are well below theirs.
std::optional<Obstacle> strain_at(const Model& model, const VecX& x);

/// Whether both are the same strain limit, or the same contact at the same place, as seen by steps of
/// different length.
bool same_obstacle(const Model& model, const Obstacle& a, const Obstacle& b);

/// "triangle 7 of cloth towel at (0, 0.1, 0) would be stretched to 1.08, strain limit 1.05".
std::string words(const Model& model, const Obstacle& obstacle);

}  // namespace cloth
