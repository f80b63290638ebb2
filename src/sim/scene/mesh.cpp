#include "sim/scene/mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "base/portable_math.h"
#include "sim/scene/rest_shape.h"

namespace cloth {
namespace {

std::string triangle_text(const Triangles& triangles, int t) {
    return "triangle " + std::to_string(t) + " (vertices " + std::to_string(triangles(t, 0)) + ", " +
           std::to_string(triangles(t, 1)) + ", " + std::to_string(triangles(t, 2)) + ", counted from 0)";
}

Points in_metres(const Points& positions, LengthUnit unit) {
    return unit == LengthUnit::metre ? positions : Points(length_of(unit) * positions);
}

}  // namespace

MeshData make_grid(const Grid& grid) {
    const int nx = grid.resolution[0], ny = grid.resolution[1];
    MeshData mesh;
    mesh.positions.resize(static_cast<Eigen::Index>(nx) * ny, 3);
    for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i) {
            mesh.positions.row(static_cast<Eigen::Index>(j) * nx + i)
                << grid.size.x() * (static_cast<double>(i) / (nx - 1) - 0.5),
                grid.size.y() * (static_cast<double>(j) / (ny - 1) - 0.5), 0.0;
        }
    }
    mesh.triangles.resize(2 * static_cast<Eigen::Index>(nx - 1) * (ny - 1), 3);
    Eigen::Index t = 0;
    for (int j = 0; j + 1 < ny; ++j) {
        for (int i = 0; i + 1 < nx; ++i) {
            const int a = j * nx + i, b = a + 1, c = a + nx, d = c + 1;  // a b below, c d above
            if (grid.diagonals == Diagonals::uniform ||
                (grid.diagonals == Diagonals::alternating && (i + j) % 2 == 0)) {
                mesh.triangles.row(t++) << a, b, c;
                mesh.triangles.row(t++) << b, d, c;
            } else {
                mesh.triangles.row(t++) << a, b, d;
                mesh.triangles.row(t++) << a, d, c;
            }
        }
    }
    return mesh;
}

MeshData make_disc(const Disc& disc) {
    MeshData mesh;
    const int m = disc.rings;
    mesh.positions.resize(1 + 3 * static_cast<Eigen::Index>(m) * (m + 1), 3);
    mesh.triangles.resize(6 * static_cast<Eigen::Index>(m) * m, 3);
    mesh.positions.row(0).setZero();
    Eigen::Index v = 1, t = 0;
    int inner = 0;  // first vertex of the ring inside
    for (int k = 1; k <= m; ++k) {
        const int outer = static_cast<int>(v);
        const double r = disc.radius * k / m;
        for (int i = 0; i < 6 * k; ++i) {
            const double degrees = 60.0 * i / k;
            mesh.positions.row(v++) << r * cos_degrees(degrees), r * sin_degrees(degrees), 0.0;
        }
        // Each sixth: k triangles with an edge on this ring, k - 1 with one on the ring inside.
        auto on_ring = [](int first, int count, int i) { return count == 0 ? first : first + i % count; };
        for (int side = 0; side < 6; ++side) {
            for (int i = 0; i < k; ++i) {
                const int a = on_ring(outer, 6 * k, side * k + i),
                          b = on_ring(outer, 6 * k, side * k + i + 1);
                const int c = on_ring(inner, 6 * (k - 1), side * (k - 1) + i);
                mesh.triangles.row(t++) << a, b, c;
                if (i + 1 < k)
                    mesh.triangles.row(t++) << b, on_ring(inner, 6 * (k - 1), side * (k - 1) + i + 1), c;
            }
        }
        inner = outer;
    }
    return mesh;
}

MeshData rest_shape(const ClothDesc& cloth) {
    if (cloth.mesh) {
        MeshData mesh = *cloth.mesh;
        mesh.positions = in_metres(mesh.positions, cloth.units);
        return mesh;
    }
    return cloth.disc ? make_disc(*cloth.disc) : make_grid(cloth.grid);
}

void check_cloth_mesh(const MeshData& mesh, const std::string& key) {
    const int n = static_cast<int>(mesh.positions.rows());
    const Triangles& F = mesh.triangles;
    if (F.rows() == 0) throw SceneError(key, "the mesh has no triangle");
    for (int i = 0; i < n; ++i) {
        if (!mesh.positions.row(i).allFinite()) {
            throw SceneError(key, "vertex " + std::to_string(i) + " (counted from 0) is not finite");
        }
    }

    std::vector<bool> used(n, false);
    std::map<std::array<int, 3>, int> seen;
    std::map<std::array<int, 2>, int> edges, ways;
    bool one_way = true;
    for (int t = 0; t < F.rows(); ++t) {
        std::array<int, 3> corners{F(t, 0), F(t, 1), F(t, 2)};
        for (int v : corners) {
            if (v < 0 || v >= n) {
                throw SceneError(
                    key, triangle_text(F, t) + " refers to a vertex outside 0 … " + std::to_string(n - 1));
            }
            used[v] = true;
        }
        for (int i = 0; i < 3; ++i) {
            const int a = corners[i], b = corners[(i + 1) % 3];
            if (a == b) throw SceneError(key, triangle_text(F, t) + " has a repeated corner");
            if (++edges[{std::min(a, b), std::max(a, b)}] > 2) {
                throw SceneError(key,
                                 "the edge of vertices " + std::to_string(a) + " and " + std::to_string(b) +
                                     " (counted from 0) has more than two triangles; cloth has at most two: "
                                     "take the third away in a modeller, which finds it as non-manifold");
            }
            if (++ways[{a, b}] > 1) one_way = false;
        }
        const Vec3 e1 = mesh.positions.row(corners[1]) - mesh.positions.row(corners[0]);
        const Vec3 e2 = mesh.positions.row(corners[2]) - mesh.positions.row(corners[0]);
        // Area against the longest edge: a needle thinner than 1e-7 of its length has no usable rest frame.
        const double longest = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
        if (!(e1.cross(e2).norm() > 1e-7 * longest)) {
            throw SceneError(
                key, triangle_text(F, t) + " is degenerate: it has no area; dissolve it in a modeller");
        }
        std::sort(corners.begin(), corners.end());
        const auto [first, inserted] = seen.emplace(corners, t);
        if (!inserted) {
            throw SceneError(key, triangle_text(F, t) + " repeats triangle " + std::to_string(first->second));
        }
    }
    const auto loose = std::find(used.begin(), used.end(), false);
    if (loose != used.end()) {
        throw SceneError(key, "vertex " + std::to_string(loose - used.begin()) +
                                  " (counted from 0) belongs to no triangle");
    }
    if (!one_way) {
        const auto twice =
            std::find_if(ways.begin(), ways.end(), [](const auto& way) { return way.second > 1; })->first;
        throw SceneError(key, "the triangles at the edge of vertices " + std::to_string(twice[0]) + " and " +
                                  std::to_string(twice[1]) +
                                  " (counted from 0) face opposite ways, and no turning helps: the sheet is "
                                  "one-sided, as a Möbius band is; cut it across and sew it with a seam");
    }
}

double usual_length(double usual, const MeshData& rest) {
    const auto& x = rest.positions;
    const double diagonal = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
    return std::min(std::max(usual, 1e-4 * diagonal), 1e-2 * diagonal);
}

void settle_lengths(Scene& scene, const std::vector<MeshData>& rest) {
    constexpr double usual = 1e-3;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
        const double length = usual_length(usual, rest[c]);
        least = std::min(least, length);
        if (!scene.cloths[c].contact_thickness) scene.cloths[c].contact_thickness = length;
        if (scene.cloths[c].rest == RestShape::uv && !scene.cloths[c].uv_scale)
            scene.cloths[c].uv_scale = natural_uv_scale(rest[c]);
    }
    if (!scene.simulation.contact_activation) scene.simulation.contact_activation = least;
}

Mat3 rotation_matrix(const Vec3& degrees) {
    auto turn = [](int axis, double angle) {
        const double c = cos_degrees(angle), s = sin_degrees(angle);
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        Mat3 R = Mat3::Identity();
        R(a, a) = c;
        R(b, b) = c;
        R(a, b) = -s;
        R(b, a) = s;
        return R;
    };
    return turn(2, degrees.z()) * turn(1, degrees.y()) * turn(0, degrees.x());
}

Points start_positions(const ClothDesc& cloth, const MeshData& rest) {
    Points x = cloth.pose ? in_metres(*cloth.pose, cloth.units) : rest.positions;
    if (cloth.bump != 0.0) {
        const Eigen::RowVector3d low = rest.positions.colwise().minCoeff();
        const Eigen::RowVector3d extent = rest.positions.colwise().maxCoeff() - low;
        auto wave = [](double along, double length) {
            return length > 0.0 ? sin_degrees(180.0 * along / length) : 1.0;
        };
        for (int i = 0; i < x.rows(); ++i) {
            x(i, 2) += cloth.bump * wave(rest.positions(i, 0) - low(0), extent(0)) *
                       wave(rest.positions(i, 1) - low(1), extent(1));
        }
    }
    const Mat3 R = rotation_matrix(cloth.transform.rotate);
    for (int i = 0; i < x.rows(); ++i) {
        const Vec3 p = x.row(i).transpose();
        x.row(i) = (R * (cloth.transform.scale * p) + cloth.transform.translate).transpose();
    }
    return x;
}

}  // namespace cloth
