#include "pipeline/picture/subdivision.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace cloth::pipeline {
namespace {

using Weights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

struct Edge {
    int middle;                           ///< number of its new vertex
    std::array<int, 2> opposite{-1, -1};  ///< the far corners of its triangles
};

/// Whether the rim turns sharply at v, or is no plain rim there (two rims that touch).
bool is_corner(const Points& rest, int v, const std::vector<int>& rim) {
    if (rim.empty()) return false;
    if (rim.size() != 2) return true;
    const Vec3 in = (rest.row(v) - rest.row(rim[0])).normalized(),
               out = (rest.row(rim[1]) - rest.row(v)).normalized();
    return in.dot(out) < 0.7;
}

Subdivision subdivide_once(const Points& rest, const Triangles& triangles) {
    const auto n = static_cast<int>(rest.rows());
    std::map<std::array<int, 2>, Edge> edges;
    int count = n;
    auto edge = [&](int a, int b) -> Edge& {
        const auto [place, inserted] = edges.try_emplace({std::min(a, b), std::max(a, b)}, Edge{count});
        count += inserted;
        return place->second;
    };
    Subdivision fine;
    fine.triangles.resize(4 * triangles.rows(), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<int, 3> middle{};
        for (int i = 0; i < 3; ++i) {
            Edge& e = edge(triangles(t, i), triangles(t, (i + 1) % 3));
            e.opposite[e.opposite[0] < 0 ? 0 : 1] = triangles(t, (i + 2) % 3);
            middle[i] = e.middle;
        }
        for (int i = 0; i < 3; ++i) {
            fine.triangles.row(4 * t + i) << triangles(t, i), middle[i], middle[(i + 2) % 3];
        }
        fine.triangles.row(4 * t + 3) << middle[0], middle[1], middle[2];
    }

    std::vector<std::vector<int>> neighbours(n), rim(n);
    std::vector<Eigen::Triplet<double>> entries, flat;
    for (int v = 0; v < n; ++v) flat.emplace_back(v, v, 1.0);
    for (const auto& [ends, e] : edges) {
        for (const int end : ends) flat.emplace_back(e.middle, end, 0.5);
        for (int k = 0; k < 2; ++k) neighbours[ends[k]].push_back(ends[1 - k]);
        const bool on_rim = e.opposite[1] < 0;
        for (int k = 0; k < 2; ++k) {
            entries.emplace_back(e.middle, ends[k], on_rim ? 0.5 : 0.375);
            if (on_rim) {
                rim[ends[k]].push_back(ends[1 - k]);
            } else {
                entries.emplace_back(e.middle, e.opposite[k], 0.125);
            }
        }
    }
    for (int v = 0; v < n; ++v) {
        if (neighbours[v].empty() || is_corner(rest, v, rim[v])) {
            entries.emplace_back(v, v, 1.0);
        } else if (!rim[v].empty()) {
            entries.emplace_back(v, v, 0.75);
            for (int u : rim[v]) entries.emplace_back(v, u, 0.125);
        } else {
            const auto valence = static_cast<double>(neighbours[v].size());
            // Warren's weights: smooth for every valence.
            const double each = valence == 3.0 ? 3.0 / 16.0 : 3.0 / (8.0 * valence);
            entries.emplace_back(v, v, 1.0 - valence * each);
            for (int u : neighbours[v]) entries.emplace_back(v, u, each);
        }
    }
    fine.weights.resize(count, n);
    fine.weights.setFromTriplets(entries.begin(), entries.end());
    fine.flat.resize(count, n);
    fine.flat.setFromTriplets(flat.begin(), flat.end());
    return fine;
}

}  // namespace

Subdivision subdivide(const Points& rest, const Triangles& triangles, int steps) {
    Weights identity(rest.rows(), rest.rows());
    identity.setIdentity();
    Subdivision result{identity, identity, triangles};
    for (int k = 0; k < steps; ++k) {
        Subdivision next = subdivide_once(result.weights * rest, result.triangles);
        next.weights = (next.weights * result.weights).eval();
        next.flat = (next.flat * result.flat).eval();
        result = std::move(next);
    }
    return result;
}

}  // namespace cloth::pipeline
