#include "sim/bending.h"

#include <map>

#include <Eigen/Dense>

namespace cloth {
namespace {

/// Far corner of the triangle across each edge: [t][i] lies opposite to corner i; -1 at the rim.
std::vector<std::array<int, 3>> find_neighbours(const Triangles& triangles) {
    std::vector<std::array<int, 3>> far(triangles.rows(), {-1, -1, -1});
    std::map<std::array<int, 2>, std::array<int, 2>> open;  // sorted edge → (triangle, corner opposite)
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) {
            const int a = triangles(t, (i + 1) % 3), b = triangles(t, (i + 2) % 3);
            const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
            const auto [first, inserted] = open.emplace(edge, std::array<int, 2>{t, i});
            if (inserted) continue;
            const auto [other, corner] = first->second;
            far[t][i] = triangles(other, corner);
            far[other][corner] = triangles(t, i);
        }
    }
    return far;
}

/// Place of the point p relative to the edge a → b, unchanged when p is turned about that edge.
struct Unfolded {
    double along, across;  ///< place along a → b [m] and distance from it [m]
};
Unfolded unfold(const Vec3& a, const Vec3& b, const Vec3& p) {
    const Vec3 edge = (b - a).normalized();
    const double along = edge.dot(p - a);
    return {along, (p - a - along * edge).norm()};
}

}  // namespace

std::vector<BendingPatch> make_bending_patches(const Points& rest, const Triangles& triangles) {
    const auto far = find_neighbours(triangles);
    std::vector<BendingPatch> patches;
    for (int t = 0; t < triangles.rows(); ++t) {
        std::array<Vec3, 3> X;
        for (int i = 0; i < 3; ++i) X[i] = rest.row(triangles(t, i));
        const Vec3 area_normal = (X[1] - X[0]).cross(X[2] - X[0]);
        const Vec3 normal = area_normal.normalized();
        const Vec3 t0 = (X[1] - X[0]).normalized(), t1 = normal.cross(t0);
        std::array<Vec2, 3> p;
        for (int i = 0; i < 3; ++i) p[i] = Vec2(t0.dot(X[i] - X[0]), t1.dot(X[i] - X[0]));

        BendingPatch patch;
        patch.area = 0.5 * area_normal.norm();
        // For f = ½ κ11 x² + κ12 x y + ½ κ22 y² + (linear), the amount by which the far corner lies off the
        // plane through the triangle: f(p) - Σ λ_i(p) f(p_i). One row per neighbour; columns scaled to κ11,
        // √2 κ12, κ22, the norm that the energy uses.
        Eigen::MatrixXd offsets(0, 3), values(0, 6);
        for (int i = 0; i < 3; ++i) {
            patch.vertices[i] = triangles(t, i);
            patch.vertices[3 + i] = far[t][i] >= 0 ? far[t][i] : triangles(t, i);
            if (far[t][i] < 0) continue;
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            const Unfolded u = unfold(X[a], X[b], rest.row(far[t][i]));
            const Vec2 edge = (p[b] - p[a]).normalized();
            const Vec2 outward(edge.y(), -edge.x());  // a → b runs counter-clockwise
            const Vec2 q = p[a] + u.along * edge + u.across * outward;

            Eigen::Matrix3d corners;
            for (int k = 0; k < 3; ++k) corners.col(k) << p[k].x(), p[k].y(), 1.0;
            const Vec3 lambda = corners.inverse() * Vec3(q.x(), q.y(), 1.0);
            auto monomials = [](const Vec2& v) {
                return Eigen::RowVector3d(0.5 * v.x() * v.x(), v.x() * v.y() / std::sqrt(2.0),
                                          0.5 * v.y() * v.y());
            };
            Eigen::RowVector3d offset = monomials(q);
            Eigen::Matrix<double, 1, 6> value = Eigen::Matrix<double, 1, 6>::Zero();
            value(3 + i) = 1.0;
            for (int k = 0; k < 3; ++k) {
                offset -= lambda(k) * monomials(p[k]);
                value(k) -= lambda(k);
            }
            offsets.conservativeResize(offsets.rows() + 1, 3);
            offsets.bottomRows<1>() = offset;
            values.conservativeResize(values.rows() + 1, 6);
            values.bottomRows<1>() = value;
        }
        patch.weights.setZero();
        if (offsets.rows() > 0) {
            patch.weights = offsets.completeOrthogonalDecomposition().solve(values);
            patch.weights.row(1) /= std::sqrt(2.0);
        }
        patches.push_back(patch);
    }
    return patches;
}

BendingEnergy::BendingEnergy(const std::vector<BendingPatch>& patches, const std::vector<double>& rigidity)
    : patches_([&] {
          std::vector<std::array<int, 6>> stencils;
          for (const BendingPatch& patch : patches) stencils.push_back(patch.vertices);
          return stencils;
      }()) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
        const auto& w = patches[k].weights;
        stiffness_.push_back(rigidity[k] * patches[k].area *
                             (w.row(0).transpose() * w.row(0) + 2.0 * w.row(1).transpose() * w.row(1) +
                              w.row(2).transpose() * w.row(2)));
    }
}

double BendingEnergy::value(const VecX& x) const {
    return patches_.sum([&](int k) {
        const Eigen::Matrix<double, 3, 6> X = patches_.gather(x, k).reshaped(3, 6);
        // Relative to a corner, so that a sheet far from the origin loses no digits.
        const Eigen::Matrix<double, 3, 6> Y = X.colwise() - X.col(0);
        return 0.5 * (Y * stiffness_[k]).cwiseProduct(Y).sum();
    });
}

void BendingEnergy::add_gradient(const VecX& x, VecX& g) const {
    patches_.add_gradient(g, [&](int k) {
        const Eigen::Matrix<double, 3, 6> X = patches_.gather(x, k).reshaped(3, 6);
        Eigen::Matrix<double, 18, 1> gradient;
        gradient.reshaped(3, 6).noalias() = (X.colwise() - X.col(0)) * stiffness_[k];
        return gradient;
    });
}

void BendingEnergy::bind(const BlockPattern& pattern) {
    hessian_.values.assign(pattern.slot_count(), 0.0);
    for (int k = 0; k < patches_.count(); ++k) {
        const auto& v = patches_.stencil(k);
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) {
                // Both orders of a pair are visited; the stored block takes the upper one. A stand-in has
                // weight 0.
                if (v[i] <= v[j] && stiffness_[k](i, j) != 0.0) {
                    hessian_.values[pattern.slot(v[i], v[j])] += stiffness_[k](i, j);
                }
            }
        }
    }
}

void BendingEnergy::add_hessian(const VecX&, HessianKind, BlockMatrix& H) const {
    parallel_for(static_cast<int>(hessian_.values.size()),
                 [&](int s) { H.blocks[s].diagonal().array() += hessian_.values[s]; });
}

}  // namespace cloth
