#include "sim/energies/bending.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Dense>

#include "sim/algebra/rest_frame.h"

namespace cloth {
namespace {

/// The triangle across an edge, and its corner (0, 1, 2) that lies opposite to the edge; -1 at the rim.
struct Across {
    int triangle = -1, corner = -1;
};
/// [t][i]: across the edge opposite to corner i.
std::vector<std::array<Across, 3>> find_neighbours(const Triangles& triangles) {
    std::vector<std::array<Across, 3>> far(triangles.rows());
    std::map<std::array<int, 2>, std::array<int, 2>> open;  // sorted edge → (triangle, corner opposite)
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) {
            const int a = triangles(t, (i + 1) % 3), b = triangles(t, (i + 2) % 3);
            const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
            const auto [first, inserted] = open.emplace(edge, std::array<int, 2>{t, i});
            if (inserted) continue;
            const auto [other, corner] = first->second;
            far[t][i] = {other, corner};
            far[other][corner] = {t, i};
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

/// K over the six vertices, from K over the folds.
Eigen::Matrix<double, 6, 6> vertex_stiffness(const BendingPatch& patch, const Mat3& rigidity) {
    return patch.offsets.transpose() * fold_stiffness(patch, rigidity) * patch.offsets;
}

std::vector<std::array<int, 6>> stencils(const std::vector<BendingPatch>& patches) {
    std::vector<std::array<int, 6>> list;
    for (const BendingPatch& patch : patches) list.push_back(patch.vertices);
    return list;
}

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Vec12 = Eigen::Matrix<double, 12, 1>;
using Vec18 = Eigen::Matrix<double, 18, 1>;

/// Patch corners of hinge i: edge, own far corner, neighbour's far corner.
std::array<int, 4> hinge_corners(int i) {
    return {(i + 1) % 3, (i + 2) % 3, i, 3 + i};
}

Mat3 cross_matrix(const Vec3& a) {
    Mat3 m;
    m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    return m;
}

}  // namespace

std::vector<BendingPatch> make_bending_patches(const Points& corners, const Triangles& triangles,
                                               const Vec3& warp) {
    const auto far = find_neighbours(triangles);
    std::vector<BendingPatch> patches;
    for (int t = 0; t < triangles.rows(); ++t) {
        std::array<Vec3, 3> X;
        for (int i = 0; i < 3; ++i) X[i] = corners.row(3 * t + i);
        const RestFrame frame = make_rest_frame(X[0], X[1], X[2], warp);
        std::array<Vec2, 3> p;
        for (int i = 0; i < 3; ++i) p[i] = frame.in_plane(X[i] - X[0]);

        BendingPatch patch;
        patch.area = frame.area;
        patch.fold_weights.setZero();
        patch.rim.setZero();
        patch.offsets.setZero();
        patch.rest_folds.setZero();
        for (int i = 0; i < 3; ++i) {
            const int a = (i + 1) % 3, b = (i + 2) % 3;
            const Vec2 along = p[b] - p[a];
            const double length = along.norm();
            const Vec2 n(along.y() / length, -along.x() / length);  // outward: a → b runs counter-clockwise
            const Vec3 nn(n.x() * n.x(), n.x() * n.y(), n.y() * n.y());
            patch.vertices[i] = triangles(t, i);
            const auto [other, corner] = far[t][i];
            patch.vertices[3 + i] = other >= 0 ? triangles(other, corner) : triangles(t, i);
            if (other < 0) {
                patch.rim.col(i) = nn;
                continue;
            }
            // The edge as the neighbour has it, which at a seam is another.
            const auto theirs = [&](int vertex) {
                const int k = triangles(other, (corner + 1) % 3) == vertex ? 1 : 2;
                return Vec3(corners.row(3 * other + (corner + k) % 3));
            };
            const Vec3 x_far = corners.row(3 * other + corner), their_a = theirs(triangles(t, a)),
                       their_b = theirs(triangles(t, b));
            const bool shared = their_a == X[a] && their_b == X[b];
            Unfolded u = unfold(their_a, their_b, x_far);
            if (!shared) u.along += 0.5 * (length - (their_b - their_a).norm());
            const double own_height = 2.0 * patch.area / length;
            patch.fold_weights.col(i) = 2.0 / (own_height + u.across) * nn;
            const Vec2 q = p[a] + u.along / length * along + u.across * n;
            Mat3 places;
            for (int k = 0; k < 3; ++k) places.col(k) << p[k].x(), p[k].y(), 1.0;
            const Vec3 lambda = places.inverse() * Vec3(q.x(), q.y(), 1.0);
            patch.offsets(i, 3 + i) = 1.0 / u.across;
            for (int k = 0; k < 3; ++k) patch.offsets(i, k) = -lambda(k) / u.across;
            if (shared) patch.rest_folds(i) = hinge_fold(X[a], X[b], X[i], x_far);
        }
        patches.push_back(patch);
    }
    return patches;
}

Mat3 bending_rigidity(double warp, double weft, std::optional<double> bias) {
    const double H = bias ? 2.0 * *bias - 0.5 * (warp + weft) : std::sqrt(warp * weft);
    return Vec3(warp, 2.0 * H, weft).asDiagonal();
}

Mat3 fold_stiffness(const BendingPatch& patch, const Mat3& rigidity) {
    const Mat3 NDN = patch.rim.transpose() * rigidity * patch.rim;
    const Mat3 DN = rigidity * patch.rim;
    Mat3 D = rigidity;
    if (!patch.rim.isZero(0.0))
        D -= DN * NDN.completeOrthogonalDecomposition().pseudoInverse() * DN.transpose();
    const Mat3 K = patch.area * (patch.fold_weights.transpose() * D * patch.fold_weights);
    return 0.5 * (K + K.transpose());
}

BendingEnergy::BendingEnergy(const std::vector<BendingPatch>& patches, const std::vector<Mat3>& rigidity)
    : patches_(stencils(patches)) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
        offsets_.push_back(patches[k].offsets);
        stiffness_.push_back(fold_stiffness(patches[k], rigidity[k]));
    }
}

double BendingEnergy::value(const VecX& x) const {
    return patches_.sum([&](int k) {
        const Eigen::Matrix<double, 3, 6> X = patches_.gather(x, k).reshaped(3, 6);
        // Relative to a corner, so that a sheet far from the origin loses no digits.
        const Mat3 folds = (X.colwise() - X.col(0)) * offsets_[k].transpose();
        return 0.5 * (folds * stiffness_[k]).cwiseProduct(folds).sum();
    });
}

void BendingEnergy::add_gradient(const VecX& x, VecX& g) const {
    patches_.add_gradient(g, [&](int k) {
        const Eigen::Matrix<double, 3, 6> X = patches_.gather(x, k).reshaped(3, 6);
        const Mat3 folds = (X.colwise() - X.col(0)) * offsets_[k].transpose();
        Eigen::Matrix<double, 18, 1> gradient;
        gradient.reshaped(3, 6).noalias() = (folds * stiffness_[k]) * offsets_[k];
        return gradient;
    });
}

void BendingEnergy::bind(const BlockPattern& pattern) {
    hessian_.values.assign(pattern.slot_count(), 0.0);
    for (int k = 0; k < patches_.count(); ++k) {
        const auto& v = patches_.stencil(k);
        const Eigen::Matrix<double, 6, 6> K = offsets_[k].transpose() * stiffness_[k] * offsets_[k];
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) {
                // Both orders of a pair are visited; the stored block takes the upper one. A stand-in has
                // weight 0.
                if (v[i] <= v[j] && K(i, j) != 0.0) {
                    hessian_.values[pattern.slot(v[i], v[j])] += K(i, j);
                }
            }
        }
    }
}

void BendingEnergy::add_hessian(const VecX&, HessianKind, BlockMatrix& H) const {
    parallel_for(static_cast<int>(hessian_.values.size()),
                 [&](int s) { H.blocks[s].diagonal().array() += hessian_.values[s]; });
}

double hinge_fold(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
    const Vec3 e = x1 - x0;
    const Vec3 n1 = e.cross(x2 - x0).normalized(), n2 = (x3 - x0).cross(e).normalized();
    // 2 tan(θ/2) = 2 sin θ / (1 + cos θ), and 1 + cos θ = ½ |n1 + n2|².
    constexpr double folded_flat = 1e-12;
    return 2.0 * e.normalized().dot(n2.cross(n1)) / std::max(0.5 * (n1 + n2).squaredNorm(), folded_flat);
}

FoldDerivatives hinge_fold_derivatives(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3,
                                       bool with_hessian) {
    const Vec3 e = x1 - x0;
    const double L = e.norm();
    const Vec3 u = e / L;
    const Vec3 N1 = e.cross(x2 - x0), N2 = (x3 - x0).cross(e);
    const double N1_2 = N1.squaredNorm(), N2_2 = N2.squaredNorm();
    const Vec3 m1 = N1 / N1_2, m2 = N2 / N2_2;
    // ∇θ: L m at the far corners; at the edge's ends what keeps θ under shifts and turns.
    const double a01 = u.dot(x1 - x2), a02 = u.dot(x1 - x3), a11 = u.dot(x2 - x0), a12 = u.dot(x3 - x0);
    Vec12 angle;
    angle << -(a01 * m1 + a02 * m2), -(a11 * m1 + a12 * m2), L * m1, L * m2;

    FoldDerivatives d;
    d.fold = hinge_fold(x0, x1, x2, x3);
    const double rate = 1.0 + 0.25 * d.fold * d.fold;  // d(2 tan(θ/2))/dθ
    d.gradient = rate * angle;
    if (!with_hessian) return d;

    using Row = Eigen::Matrix<double, 1, 12>;
    using Jacobian = Eigen::Matrix<double, 3, 12>;
    Row dL = Row::Zero();
    dL.segment<3>(0) = -u;
    dL.segment<3>(3) = u;
    const Mat3 across = (Mat3::Identity() - u * u.transpose()) / L;  // du = across (dx1 - dx0)
    auto projection = [&](const Vec3& way, int plus, int minus) {    // d(u·(x_plus - x_minus))
        Row row = Row::Zero();
        row.segment<3>(3 * plus) += u;
        row.segment<3>(3 * minus) -= u;
        const Vec3 turn = across * way;
        row.segment<3>(3) += turn;
        row.segment<3>(0) -= turn;
        return row;
    };
    auto inverted = [](const Vec3& N, double N_2, const Jacobian& dN) -> Jacobian {  // d(N/|N|²)
        return (dN - 2.0 / N_2 * N * (N.transpose() * dN)) / N_2;
    };
    Jacobian dN1 = Jacobian::Zero(), dN2 = Jacobian::Zero();
    dN1.middleCols<3>(0) = cross_matrix(x2 - x1);  // N1 = x0×x1 + x1×x2 + x2×x0
    dN1.middleCols<3>(3) = cross_matrix(x0 - x2);
    dN1.middleCols<3>(6) = cross_matrix(x1 - x0);
    dN2.middleCols<3>(0) = cross_matrix(x1 - x3);  // N2 = x1×x0 + x0×x3 + x3×x1
    dN2.middleCols<3>(3) = cross_matrix(x3 - x0);
    dN2.middleCols<3>(9) = cross_matrix(x0 - x1);
    const Jacobian dm1 = inverted(N1, N1_2, dN1), dm2 = inverted(N2, N2_2, dN2);
    Eigen::Matrix<double, 12, 12> H;
    H.middleRows<3>(0) =
        -(m1 * projection(x1 - x2, 1, 2) + a01 * dm1 + m2 * projection(x1 - x3, 1, 3) + a02 * dm2);
    H.middleRows<3>(3) =
        -(m1 * projection(x2 - x0, 2, 0) + a11 * dm1 + m2 * projection(x3 - x0, 3, 0) + a12 * dm2);
    H.middleRows<3>(6) = m1 * dL + L * dm1;
    H.middleRows<3>(9) = m2 * dL + L * dm2;
    d.hessian = rate * (0.5 * (H + H.transpose()) + 0.5 * d.fold * angle * angle.transpose());
    return d;
}

VecX HingeEnergy::rest_folds(const std::vector<BendingPatch>& patches) {
    VecX folds(3 * patches.size());
    for (std::size_t k = 0; k < patches.size(); ++k) folds.segment<3>(3 * k) = patches[k].rest_folds;
    return folds;
}

HingeEnergy::HingeEnergy(const std::vector<BendingPatch>& patches, const std::vector<Mat3>& rigidity,
                         std::vector<double> yield_curvature)
    : patches_(stencils(patches)), yield_(std::move(yield_curvature)), rest_folds_(rest_folds(patches)) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
        stiffness_.push_back(fold_stiffness(patches[k], rigidity[k]));
        // A column of fold_weights is 2/(h_t + h_n) (n_x², n_x n_y, n_y²).
        curvature_per_fold_.push_back(
            (patches[k].fold_weights.row(0) + patches[k].fold_weights.row(2)).transpose());
    }
}

void HingeEnergy::begin(const Stage& stage) {
    if (stage.state.rest_folds.size() > 0) rest_folds_ = stage.state.rest_folds;
}

Vec3 HingeEnergy::folds(const Vec18& q, int k) const {
    Vec3 f = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
        if (curvature_per_fold_[k](i) == 0.0) continue;
        const auto [a, b, c, d] = hinge_corners(i);
        f(i) =
            hinge_fold(q.segment<3>(3 * a), q.segment<3>(3 * b), q.segment<3>(3 * c), q.segment<3>(3 * d)) -
            rest_folds_(3 * k + i);
    }
    return f;
}

double HingeEnergy::value(const VecX& x) const {
    return patches_.sum([&](int k) {
        const Vec3 f = folds(patches_.gather(x, k), k);
        return 0.5 * f.dot(stiffness_[k] * f);
    });
}

void HingeEnergy::add_gradient(const VecX& x, VecX& g) const {
    patches_.add_gradient(g, [&](int k) {
        const Vec18 q = patches_.gather(x, k);
        const Vec3 force = stiffness_[k] * folds(q, k);
        Vec18 gradient = Vec18::Zero();
        for (int i = 0; i < 3; ++i) {
            if (curvature_per_fold_[k](i) == 0.0) continue;
            const auto corners = hinge_corners(i);
            const auto [a, b, c, d] = corners;
            const FoldDerivatives f = hinge_fold_derivatives(q.segment<3>(3 * a), q.segment<3>(3 * b),
                                                             q.segment<3>(3 * c), q.segment<3>(3 * d), false);
            for (int v = 0; v < 4; ++v) {
                gradient.segment<3>(3 * corners[v]) += force(i) * f.gradient.segment<3>(3 * v);
            }
        }
        return gradient;
    });
}

void HingeEnergy::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    const bool exact = kind == HessianKind::exact;
    patches_.add_hessian(H, [&](int k) {
        const Vec18 q = patches_.gather(x, k);
        const Vec3 force = stiffness_[k] * folds(q, k);
        Eigen::Matrix<double, 18, 3> gradients = Eigen::Matrix<double, 18, 3>::Zero();
        Eigen::Matrix<double, 18, 18> hessian = Eigen::Matrix<double, 18, 18>::Zero();
        for (int i = 0; i < 3; ++i) {
            if (curvature_per_fold_[k](i) == 0.0) continue;
            const auto corners = hinge_corners(i);
            const auto [a, b, c, d] = corners;
            const FoldDerivatives f = hinge_fold_derivatives(q.segment<3>(3 * a), q.segment<3>(3 * b),
                                                             q.segment<3>(3 * c), q.segment<3>(3 * d), exact);
            for (int v = 0; v < 4; ++v) {
                gradients.block<3, 1>(3 * corners[v], i) = f.gradient.segment<3>(3 * v);
                for (int w = 0; exact && w < 4; ++w) {
                    hessian.block<3, 3>(3 * corners[v], 3 * corners[w]) +=
                        force(i) * f.hessian.block<3, 3>(3 * v, 3 * w);
                }
            }
        }
        hessian.noalias() += gradients * stiffness_[k] * gradients.transpose();
        return hessian;
    });
}

void HingeEnergy::finish(State& state) const {
    if (state.rest_folds.size() == 0) return;
    parallel_for(patches_.count(), [&](int k) {
        if (yield_[k] == 0.0) return;
        const Vec3 f = folds(patches_.gather(state.positions, k), k);
        for (int i = 0; i < 3; ++i) {
            if (curvature_per_fold_[k](i) == 0.0) continue;
            const double most = yield_[k] / curvature_per_fold_[k](i);
            if (f(i) > most) state.rest_folds(3 * k + i) += f(i) - most;
            if (f(i) < -most) state.rest_folds(3 * k + i) += f(i) + most;
        }
    });
}

BendingViscosity::BendingViscosity(const std::vector<BendingPatch>& patches,
                                   const std::vector<Mat3>& rigidity)
    : patches_(stencils(patches)), normals_(patches.size(), Vec3::Zero()) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
        viscosity_.push_back(vertex_stiffness(patches[k], rigidity[k]));
    }
}

void BendingViscosity::begin(const Stage& stage) {
    h_ = stage.h;
    base_ = stage.base();
    parallel_for(patches_.count(), [&](int k) {
        const auto& v = patches_.stencil(k);
        const VecX& x = stage.past.front().positions;
        const Vec3 x0 = x.segment<3>(3 * v[0]);
        normals_[k] = (x.segment<3>(3 * v[1]) - x0).cross(x.segment<3>(3 * v[2]) - x0).normalized();
    });
}

double BendingViscosity::value(const VecX& x) const {
    return patches_.sum([&](int k) {
        const Vec18 way = patches_.gather(x, k) - patches_.gather(base_, k);
        const Vec6 out = way.reshaped(3, 6).transpose() * normals_[k];
        return 0.5 * out.dot(viscosity_[k] * out);
    }) / h_;
}

void BendingViscosity::add_gradient(const VecX& x, VecX& g) const {
    patches_.add_gradient(g, [&](int k) {
        const Vec18 way = patches_.gather(x, k) - patches_.gather(base_, k);
        const Vec6 out = way.reshaped(3, 6).transpose() * normals_[k];
        Vec18 gradient;
        gradient.reshaped(3, 6).noalias() = normals_[k] * (viscosity_[k] * out / h_).transpose();
        return gradient;
    });
}

void BendingViscosity::add_hessian(const VecX&, HessianKind, BlockMatrix& H) const {
    patches_.add_hessian(H, [&](int k) {
        const Mat3 nn = normals_[k] * normals_[k].transpose() / h_;
        Eigen::Matrix<double, 18, 18> hessian;
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) hessian.block<3, 3>(3 * i, 3 * j) = viscosity_[k](i, j) * nn;
        }
        return hessian;
    });
}

double bending_length(const Fabric& f) {
    // D_warp, 2H, D_weft: cos⁴, cos² sin² and sin⁴ of the angle to the warp average to 3/8, 1/8 and 3/8.
    const Vec3 D = bending_rigidity(f.bending, f.bending_weft.value_or(f.bending), f.bending_bias).diagonal();
    return std::cbrt(0.125 * (3.0 * D(0) + D(1) + 3.0 * D(2)) / (f.density * 9.81));
}

}  // namespace cloth
