#pragma once
// Boxes along the axes, and the shape of a tree of them.

#include <vector>

#include "sim/algebra/types.h"

namespace cloth {

struct Box {
    Vec3 low = Vec3::Constant(1.0 / 0.0), high = Vec3::Constant(-1.0 / 0.0);

    void add(const Vec3& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    void add(const Box& b) {
        low = low.cwiseMin(b.low);
        high = high.cwiseMax(b.high);
    }
    void inflate(double r) {
        low.array() -= r;
        high.array() += r;
    }
};

/// A binary tree over things in space: cut in halves along the longest axis of their centres until four or
/// fewer are left. The same for the same centres.
struct BoxTree {
    struct Node {
        int first, count;           ///< places in `order` of what stands below
        int left = -1, right = -1;  ///< -1: a leaf
    };
    explicit BoxTree(const std::vector<Vec3>& centres);

    std::vector<int> order;   ///< the things; each node's stand in a row
    std::vector<Node> nodes;  ///< the root first, children after parents; none where there are no things

  private:
    int build(const std::vector<Vec3>& centres, int first, int count);
};

}  // namespace cloth
