#pragma once
// Steps start free of overlap, or are refused.

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/contact/contact_set.h"
#include "sim/model.h"

namespace cloth {

struct Overlap {
    std::array<int, 2> faces{-1, -1};            ///< two triangles that cross, in ContactMesh numbers; or
    std::array<int, 4> points{-1, -1, -1, -1};   ///< a pair nearer than its thickness; a plane: one vertex
    double gap = 0.0;                            ///< [m]
    int body_a = -1, body_b = -1;                ///< body_b = -1 - p: plane p
    std::vector<std::array<Vec3, 3>> corners{};  ///< of `faces`, as they stand [m]
};

/// Triangles that cross and pairs nearer than their thickness, at x; at most `most`.
std::vector<Overlap> find_overlaps(const ContactSet& set, const VecX& x, std::size_t most);

/// Thrown where a step starts with things that overlap.
class OverlapError : public std::runtime_error {
  public:
    OverlapError(const std::string& message, std::vector<int> numbers,
                 std::vector<std::array<Vec3, 3>> corners)
        : std::runtime_error(message), cloth_triangles(std::move(numbers)), triangles(std::move(corners)) {}
    std::vector<int> cloth_triangles;            ///< over all cloths
    std::vector<std::array<Vec3, 3>> triangles;  ///< corners of cloth's and colliders', as they stand [m]
};

/// Throws OverlapError where anything overlaps at x, with what overlaps and where. `occasion`: what began it
/// (" at 0.5 s, …"); empty: the start of a run, and then with how far to move which cloth, where that frees
/// it.
void require_no_overlap(const Model& model, ContactSet& set, const VecX& x, const std::string& occasion);

}  // namespace cloth
