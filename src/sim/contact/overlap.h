#pragma once
// Steps start free of overlap, or are refused.

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/contact/barrier_contact.h"
#include "sim/model.h"

namespace cloth {

/// Thrown where a step starts with things that overlap.
class OverlapError : public std::runtime_error {
  public:
    OverlapError(const std::string& message, std::vector<int> numbers,
                 std::vector<std::array<Vec3, 3>> corners)
        : std::runtime_error(message), cloth_triangles(std::move(numbers)), triangles(std::move(corners)) {}
    std::vector<int> cloth_triangles;            ///< over all cloths
    std::vector<std::array<Vec3, 3>> triangles;  ///< corners of cloth's and colliders', as they stand [m]
};

/// Throws OverlapError where anything overlaps at x, naming up to ten pairs.
void require_no_overlap(const Model& model, const BarrierContact& contact, const VecX& x);

}  // namespace cloth
