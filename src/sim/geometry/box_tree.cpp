#include "sim/geometry/box_tree.h"

#include <algorithm>
#include <numeric>

namespace cloth {

BoxTree::BoxTree(const std::vector<Vec3>& centres) : order(centres.size()) {
    std::iota(order.begin(), order.end(), 0);
    if (!centres.empty()) build(centres, 0, static_cast<int>(centres.size()));
}

int BoxTree::build(const std::vector<Vec3>& centres, int first, int count) {
    constexpr int leaf_size = 4;
    const int n = static_cast<int>(nodes.size());
    nodes.push_back({first, count});
    if (count <= leaf_size) return n;
    Box box;
    for (int i = first; i < first + count; ++i) box.add(centres[order[i]]);
    int axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    const int half = count / 2;
    std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                     [&](int i, int j) {
                         if (centres[i](axis) != centres[j](axis)) return centres[i](axis) < centres[j](axis);
                         return i < j;
                     });
    const int left = build(centres, first, half);
    const int right = build(centres, first + half, count - half);
    nodes[n].left = left;
    nodes[n].right = right;
    return n;
}

}  // namespace cloth
