#include "sim/scene/mesh_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include <Eigen/Geometry>

namespace cloth {
namespace {

// ---------------------------------------------------------------- vertices at one place

double size_of(const Points& points) {
    return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

/// Distance below which two points are one [m].
double one_place(const Points& points, const Triangles& triangles) {
    double shortest = std::numeric_limits<double>::infinity();
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const double length =
                (points.row(triangles(t, k)) - points.row(triangles(t, (k + 1) % 3))).norm();
            if (length > 0.0) shortest = std::min(shortest, length);
        }
    }
    const double size = size_of(points);
    // Nothing smaller than what the cells below can count.
    return std::max(std::min(1e-2 * shortest, 1e-5 * size), 1e-9 * size);
}

/// Points in cells of space.
class Places {
  public:
    explicit Places(const Points& points, double reach)
        : points_(points), low_(points.colwise().minCoeff()), reach_(reach), cell_(4.0 * reach) {}

    /// The first point put before that is within reach of point `v` and pleases `also`, or -1.
    template <class Also>
    int find(int v, const Also& also) const {
        const Eigen::RowVector3d p = points_.row(v);
        int found = -1;
        const Cell low = cell(p.array() - reach_), high = cell(p.array() + reach_);
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    const auto here = cells_.find({x, y, z});
                    if (here == cells_.end()) continue;
                    for (const int other : here->second) {
                        if (found >= 0 && other >= found) continue;
                        if ((points_.row(other) - p).norm() <= reach_ && also(other)) found = other;
                    }
                }
            }
        }
        return found;
    }
    void put(int v) { cells_[cell(points_.row(v).array())].push_back(v); }

  private:
    using Cell = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Cell& c) const {
            std::uint64_t h = 0;
            for (const std::int64_t each : c)
                h = (h ^ static_cast<std::uint64_t>(each)) * 0x9e3779b97f4a7c15U;
            return static_cast<std::size_t>(h ^ (h >> 32));
        }
    };
    template <class Row>
    Cell cell(const Row& p) const {
        Cell c{};
        if (!(cell_ > 0.0)) return c;  // all points at one place
        for (int k = 0; k < 3; ++k)
            c[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor((p(k) - low_(k)) / cell_));
        return c;
    }

    const Points& points_;
    Eigen::RowVector3d low_;
    double reach_, cell_;
    std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

/// Of each vertex the first one at its place.
std::vector<int> first_at_place(const MeshData& mesh, const Points* pose) {
    const int n = static_cast<int>(mesh.positions.rows());
    std::vector<int> first(static_cast<std::size_t>(n));
    std::iota(first.begin(), first.end(), 0);
    // Squares of what is absurdly far apart are no numbers.
    const auto measurable = [](const Points& points) { return std::isfinite(size_of(points)); };
    if (n == 0 || !measurable(mesh.positions)) return first;
    if (pose && (pose->rows() != n || !measurable(*pose))) return first;
    Places places(mesh.positions, one_place(mesh.positions, mesh.triangles));
    const double pose_reach = pose ? one_place(*pose, mesh.triangles) : 0.0;
    for (int v = 0; v < n; ++v) {
        const int other = places.find(
            v, [&](int w) { return !pose || (pose->row(v) - pose->row(w)).norm() <= pose_reach; });
        if (other < 0) {
            places.put(v);
        } else {
            first[static_cast<std::size_t>(v)] = other;
        }
    }
    return first;
}

// ---------------------------------------------------------------- facing one way

/// Neighbours of triangles across edges of exactly two triangles; `same` where both face one way.
struct Neighbour {
    int triangle;
    bool same;
};

std::vector<std::vector<Neighbour>> neighbours(const Triangles& triangles) {
    struct Side {
        int triangle;
        bool up;  ///< along the edge from its lower vertex to its higher one
    };
    std::map<std::array<int, 2>, std::vector<Side>> edges;
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            edges[{std::min(a, b), std::max(a, b)}].push_back({t, a < b});
        }
    }
    std::vector<std::vector<Neighbour>> found(static_cast<std::size_t>(triangles.rows()));
    for (const auto& [edge, sides] : edges) {
        if (sides.size() != 2) continue;
        const bool same = sides[0].up != sides[1].up;
        found[static_cast<std::size_t>(sides[0].triangle)].push_back({sides[1].triangle, same});
        found[static_cast<std::size_t>(sides[1].triangle)].push_back({sides[0].triangle, same});
    }
    return found;
}

/// Turns triangles; a piece that cannot face one way is left as it is.
int face_one_way(MeshData& mesh) {
    const auto next_to = neighbours(mesh.triangles);
    const auto area = [&](int t) {
        const Vec3 a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                   c = mesh.positions.row(mesh.triangles(t, 2));
        return 0.5 * (b - a).cross(c - a).norm();
    };
    enum class Facing : std::uint8_t { unknown, kept, against };
    std::vector<Facing> facing(next_to.size(), Facing::unknown);
    int turned = 0;
    std::vector<int> piece;
    for (int seed = 0; seed < static_cast<int>(next_to.size()); ++seed) {
        if (facing[static_cast<std::size_t>(seed)] != Facing::unknown) continue;
        facing[static_cast<std::size_t>(seed)] = Facing::kept;
        piece.assign(1, seed);
        bool two_sided = true;
        double kept = 0.0, against = 0.0;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            const int t = piece[i];
            const Facing own = facing[static_cast<std::size_t>(t)];
            (own == Facing::kept ? kept : against) += area(t);
            for (const auto& [other, same] : next_to[static_cast<std::size_t>(t)]) {
                const Facing wanted = (own == Facing::kept) == same ? Facing::kept : Facing::against;
                Facing& theirs = facing[static_cast<std::size_t>(other)];
                if (theirs == Facing::unknown) {
                    theirs = wanted;
                    piece.push_back(other);
                }
                two_sided = two_sided && theirs == wanted;
            }
        }
        if (!two_sided) continue;
        const Facing wrong = against > kept * (1.0 + 1e-9) ? Facing::kept : Facing::against;
        for (const int t : piece) {
            if (facing[static_cast<std::size_t>(t)] != wrong) continue;
            std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
            if (mesh.uv.rows() > 0) mesh.uv.row(3 * t + 1).swap(mesh.uv.row(3 * t + 2));
            ++turned;
        }
    }
    return turned;
}

}  // namespace

MeshRepair repair_cloth_mesh(const MeshData& mesh, const Points* pose, bool weld) {
    const int n = static_cast<int>(mesh.positions.rows());
    MeshRepair repair;
    std::vector<int> first = first_at_place(mesh, pose);
    std::vector<bool> in_triangle(first.size(), false);
    for (const int v : mesh.triangles.reshaped()) in_triangle[static_cast<std::size_t>(v)] = true;
    for (int v = 0; v < n; ++v) {
        const bool other = first[static_cast<std::size_t>(v)] != v;
        if (other && in_triangle[static_cast<std::size_t>(v)]) ++(weld ? repair.joined : repair.doubled);
    }
    if (!weld) std::iota(first.begin(), first.end(), 0);

    std::vector<std::array<int, 3>> kept;
    std::vector<int> triangle_of(static_cast<std::size_t>(mesh.triangles.rows()), -1);
    std::vector<int> given_corners;  // of the triangles kept
    std::set<std::array<int, 3>> seen;
    std::vector<bool> used(first.size(), false);
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        std::array<int, 3> corners{};
        for (int k = 0; k < 3; ++k)
            corners[static_cast<std::size_t>(k)] = first[static_cast<std::size_t>(mesh.triangles(t, k))];
        std::array<int, 3> sorted = corners;
        std::sort(sorted.begin(), sorted.end());
        if (sorted[0] == sorted[1] || sorted[1] == sorted[2]) {
            ++repair.collapsed;
        } else if (!seen.insert(sorted).second) {
            ++repair.repeated;
        } else {
            triangle_of[static_cast<std::size_t>(t)] = static_cast<int>(kept.size());
            for (int k = 0; k < 3; ++k) given_corners.push_back(static_cast<int>(3 * t) + k);
            kept.push_back(corners);
            for (const int v : corners) used[static_cast<std::size_t>(v)] = true;
        }
    }

    // A vertex that was loose from the start may stand where another does: it goes with that one.
    repair.vertex_of.assign(first.size(), -1);
    for (int v = 0; v < n; ++v) {
        if (!used[static_cast<std::size_t>(v)]) continue;
        repair.vertex_of[static_cast<std::size_t>(v)] = static_cast<int>(repair.given.size());
        repair.given.push_back(v);
    }
    for (int v = 0; v < n; ++v) {
        repair.vertex_of[static_cast<std::size_t>(v)] =
            repair.vertex_of[static_cast<std::size_t>(first[static_cast<std::size_t>(v)])];
        if (repair.vertex_of[static_cast<std::size_t>(v)] < 0) ++repair.loose;
    }
    repair.mesh.positions = mesh.positions(repair.given, Eigen::all);
    repair.mesh.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t t = 0; t < kept.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k)
            repair.mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) =
                repair.vertex_of[static_cast<std::size_t>(kept[t][k])];
    }
    if (mesh.uv.rows() > 0) repair.mesh.uv = mesh.uv(given_corners, Eigen::all);
    for (const MeshPart& part : mesh.parts) {
        MeshPart own{part.name, {}};
        for (const int t : part.triangles) {
            if (triangle_of[static_cast<std::size_t>(t)] >= 0)
                own.triangles.push_back(triangle_of[static_cast<std::size_t>(t)]);
        }
        if (!own.triangles.empty()) repair.mesh.parts.push_back(std::move(own));
    }
    repair.mesh.pattern = mesh.pattern;
    for (const auto& [first_row, second_row] : mesh.stitches) {
        std::array<std::vector<int>, 2>& row = repair.mesh.stitches.emplace_back();
        for (std::size_t k = 0; k < first_row.size(); ++k) {
            const int a = repair.vertex_of[static_cast<std::size_t>(first_row[k])],
                      b = repair.vertex_of[static_cast<std::size_t>(second_row[k])];
            if (a < 0 || b < 0 || a == b) continue;  // loose, or one already
            row[0].push_back(a);
            row[1].push_back(b);
        }
    }
    repair.turned = face_one_way(repair.mesh);
    return repair;
}

}  // namespace cloth
