#include "sim/assignment/assignment.h"

#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

namespace cloth {
namespace {

Mat3 cross_matrix(const Vec3& a) {
    Mat3 m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

/// Rest normal: perpendicular to the gradients of φ1 and φ2, which turn the same way as the triangle's edges.
Vec3 rest_normal(const Mat3& dphi) {
    const Vec3 b1 = dphi.row(1).transpose(), b2 = dphi.row(2).transpose();
    return b1.cross(b2).normalized();
}

struct Stretches {
    Mat3 U, W;
    Vec3 s;
    Vec3 dpsi;  ///< ∂ψ/∂s
};

Stretches principal_stretches(const Mat3& F, double mu, double lambda) {
    const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Stretches r{svd.matrixU(), svd.matrixV(), svd.singularValues(), {}};
    r.dpsi = 2.0 * mu * (r.s.array() - 1.0) + lambda * (r.s.sum() - 3.0);
    return r;
}

/// ∂²ψ/∂F², shape (9, 9), entries ordered by row: index 3 a + b is F_ab.
///
/// For dF, put A = Uᵀ dF W. The diagonal of A changes the stretches; a pair of off-diagonal entries (i, j)
/// splits into a symmetric part, which meets (ψ_i - ψ_j)/(s_i - s_j) = 2 mu, and a rotation, which meets (ψ_i
/// + ψ_j)/(s_i + s_j).
Mat9 d2psi_dF2(const Stretches& r, double mu, double lambda) {
    Mat9 H;
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            const Mat3 A = r.U.row(a).transpose() * r.W.row(b);  // Uᵀ E_ab W
            Mat3 D = 2.0 * mu * Mat3(A.diagonal().asDiagonal()) + lambda * A.trace() * Mat3::Identity();
            for (int i = 0; i < 3; ++i) {
                for (int j = i + 1; j < 3; ++j) {
                    const double symmetric = 0.5 * (A(i, j) + A(j, i)) * 2.0 * mu;
                    const double twist = (r.dpsi(i) + r.dpsi(j)) / (r.s(i) + r.s(j));
                    const double rotation = 0.5 * (A(i, j) - A(j, i)) * twist;
                    D(i, j) = symmetric + rotation;
                    D(j, i) = symmetric - rotation;
                }
            }
            const Mat3 dP = r.U * D * r.W.transpose();
            for (int c = 0; c < 3; ++c) {
                for (int d = 0; d < 3; ++d) H(3 * c + d, 3 * a + b) = dP(c, d);
            }
        }
    }
    return H;
}

Vec9 triangle_positions(VecRef q, const Triangles& F, int t) {
    Vec9 q9;
    for (int i = 0; i < 3; ++i) q9.segment<3>(3 * i) = q.segment<3>(3 * F(t, i));
    return q9;
}

void add_blocks(std::vector<Eigen::Triplet<double>>& triplets, const Mat9& block, const Triangles& F, int t,
                double factor) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            for (int a = 0; a < 3; ++a) {
                for (int b = 0; b < 3; ++b) {
                    const double value = factor * block(3 * i + a, 3 * j + b);
                    if (value != 0.0) triplets.emplace_back(3 * F(t, i) + a, 3 * F(t, j) + b, value);
                }
            }
        }
    }
}

/// Where the ray origin + t direction meets the triangle, t ≥ 0; infinity where it does not (Möller,
/// Trumbore).
double ray_triangle(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& b, const Vec3& c) {
    constexpr double miss = std::numeric_limits<double>::infinity();
    const Vec3 e1 = b - a, e2 = c - a;
    const Vec3 p = direction.cross(e2);
    const double det = e1.dot(p);
    if (det == 0.0) return miss;
    const Vec3 s = origin - a;
    const double u = s.dot(p) / det;
    const Vec3 r = s.cross(e1);
    const double v = direction.dot(r) / det;
    const double t = e2.dot(r) / det;
    return (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0) ? t : miss;
}

/// Pixel → normalised device coordinates; y turns from down to up.
Vec2 pixel_to_ndc(const Vec2& win, const Vec2& viewport) {
    return {2.0 * win.x() / viewport.x() - 1.0, 1.0 - 2.0 * win.y() / viewport.y()};
}

}  // namespace

Mat3 dphi_cloth_triangle_dX(const Vec3& X0, const Vec3& X1, const Vec3& X2) {
    Eigen::Matrix<double, 3, 2> T;
    T << X1 - X0, X2 - X0;
    const Eigen::Matrix<double, 2, 3> inverse = (T.transpose() * T).inverse() * T.transpose();
    Mat3 dphi;
    dphi.row(0) = -inverse.colwise().sum();
    dphi.bottomRows<2>() = inverse;
    return dphi;
}

Mat3 deformation_gradient(const Mat3& dphi, const Vec9& q9) {
    const Mat3 x = q9.reshaped(3, 3);
    const Vec3 n = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).normalized();
    return x * dphi + n * rest_normal(dphi).transpose();
}

Mat9 deformation_gradient_dq(const Mat3& dphi, const Vec9& q9) {
    const Mat3 x = q9.reshaped(3, 3);
    const Vec3 e1 = x.col(1) - x.col(0), e2 = x.col(2) - x.col(0);
    const Vec3 area_normal = e1.cross(e2);
    const Vec3 n = area_normal.normalized();
    // d(e1 × e2) = [e1]× de2 - [e2]× de1, then the change of length is projected out.
    Eigen::Matrix<double, 3, 9> dn;
    dn << cross_matrix(e2) - cross_matrix(e1), -cross_matrix(e2), cross_matrix(e1);
    dn = ((Mat3::Identity() - n * n.transpose()) / area_normal.norm() * dn).eval();

    const Vec3 N = rest_normal(dphi);
    Mat9 B;
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            B.row(3 * a + b) = N(b) * dn.row(a);
            for (int i = 0; i < 3; ++i) B(3 * a + b, 3 * i + a) += dphi(i, b);
        }
    }
    return B;
}

Mat9 mass_matrix_triangle(double mass) {
    Mat9 M = Mat9::Zero();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            M.block<3, 3>(3 * i, 3 * j) = mass / (i == j ? 6.0 : 12.0) * Mat3::Identity();
        }
    }
    return M;
}

SparseMatrix mass_matrix_mesh(int vertex_count, const Triangles& F, double density, VecRef areas) {
    std::vector<Eigen::Triplet<double>> triplets;
    for (int t = 0; t < F.rows(); ++t) {
        add_blocks(triplets, mass_matrix_triangle(density * areas(t)), F, t, 1.0);
    }
    SparseMatrix M(3 * vertex_count, 3 * vertex_count);
    M.setFromTriplets(triplets.begin(), triplets.end());
    return M;
}

double T_cloth(VecRef qdot, const SparseMatrix& M) {
    return 0.5 * qdot.dot(M * qdot);
}

VecX dV_cloth_gravity_dq(const SparseMatrix& M, const Vec3& g) {
    return -(M * g.replicate(M.rows() / 3, 1));
}

double V_membrane_corotational(const Mat3& dphi, const Vec9& q9, double volume, double mu, double lambda) {
    const Vec3 s = Eigen::JacobiSVD<Mat3>(deformation_gradient(dphi, q9)).singularValues();
    const double trace = s.sum() - 3.0;
    return volume * (mu * (s.array() - 1.0).square().sum() + 0.5 * lambda * trace * trace);
}

Vec9 dV_membrane_corotational_dq(const Mat3& dphi, const Vec9& q9, double volume, double mu, double lambda) {
    const Stretches r = principal_stretches(deformation_gradient(dphi, q9), mu, lambda);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P = r.U * r.dpsi.asDiagonal() * r.W.transpose();
    return volume * deformation_gradient_dq(dphi, q9).transpose() * Eigen::Map<const Vec9>(P.data());
}

Mat9 d2V_membrane_corotational_dq2_unfixed(const Mat3& dphi, const Vec9& q9, double volume, double mu,
                                           double lambda) {
    const Stretches r = principal_stretches(deformation_gradient(dphi, q9), mu, lambda);
    const Mat9 B = deformation_gradient_dq(dphi, q9);
    return volume * B.transpose() * d2psi_dF2(r, mu, lambda) * B;
}

Mat9 d2V_membrane_corotational_dq2(const Mat3& dphi, const Vec9& q9, double volume, double mu,
                                   double lambda) {
    const Mat9 H = d2V_membrane_corotational_dq2_unfixed(dphi, q9, volume, mu, lambda);
    const Eigen::SelfAdjointEigenSolver<Mat9> solver(0.5 * (H + H.transpose()));
    const Vec9 values = solver.eigenvalues().unaryExpr([](double v) { return v < 1e-6 ? 1e-3 : v; });
    return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

double V_spring_particle_particle(const Vec3& q0, const Vec3& q1, double l0, double stiffness) {
    const double extension = (q1 - q0).norm() - l0;
    return 0.5 * stiffness * extension * extension;
}

Eigen::Matrix<double, 6, 1> dV_spring_particle_particle_dq(const Vec3& q0, const Vec3& q1, double l0,
                                                           double stiffness) {
    const Vec3 d = q1 - q0;
    const double length = d.norm();
    // k (l - l0) d / l; for l0 = 0 it is k d, without a division at coinciding ends.
    Vec3 force = stiffness * d;
    if (l0 != 0.0 && length > 0.0) force *= (length - l0) / length;
    Eigen::Matrix<double, 6, 1> gradient;
    gradient.head<3>() = -force;
    gradient.tail<3>() = force;
    return gradient;
}

VecX assemble_forces(VecRef q, const std::vector<Mat3>& dphi, const Triangles& F, VecRef volumes, double mu,
                     double lambda) {
    VecX f = VecX::Zero(q.size());
    for (int t = 0; t < F.rows(); ++t) {
        const Vec9 gradient =
            dV_membrane_corotational_dq(dphi[t], triangle_positions(q, F, t), volumes(t), mu, lambda);
        for (int i = 0; i < 3; ++i) f.segment<3>(3 * F(t, i)) -= gradient.segment<3>(3 * i);
    }
    return f;
}

SparseMatrix assemble_stiffness(VecRef q, const std::vector<Mat3>& dphi, const Triangles& F, VecRef volumes,
                                double mu, double lambda) {
    std::vector<Eigen::Triplet<double>> triplets;
    for (int t = 0; t < F.rows(); ++t) {
        const Mat9 H =
            d2V_membrane_corotational_dq2(dphi[t], triangle_positions(q, F, t), volumes(t), mu, lambda);
        add_blocks(triplets, H, F, t, -1.0);
    }
    SparseMatrix K(q.size(), q.size());
    K.setFromTriplets(triplets.begin(), triplets.end());
    return K;
}

SparseMatrix fixed_point_constraints(int vertex_count, const std::vector<int>& pinned) {
    SparseMatrix P(3 * (vertex_count - static_cast<int>(pinned.size())), 3 * vertex_count);
    std::vector<Eigen::Triplet<double>> triplets;
    std::size_t next = 0;
    for (int i = 0, row = 0; i < vertex_count; ++i) {
        if (next < pinned.size() && pinned[next] == i) {
            ++next;
            continue;
        }
        for (int a = 0; a < 3; ++a) triplets.emplace_back(row++, 3 * i + a, 1.0);
    }
    P.setFromTriplets(triplets.begin(), triplets.end());
    return P;
}

void linearly_implicit_euler(VecX& q, VecX& qdot, double dt, const SparseMatrix& M,
                             const std::function<VecX(VecRef)>& force,
                             const std::function<SparseMatrix(VecRef)>& stiffness) {
    const SparseMatrix A = M - dt * dt * stiffness(q);
    const Eigen::SimplicialLDLT<SparseMatrix> solver(A);
    qdot = solver.solve(M * qdot + dt * force(q)).eval();
    q += dt * qdot;
}

SphereContacts collision_detection_cloth_sphere(VecRef q, const Vec3& center, double radius) {
    SphereContacts contacts;
    for (int i = 0; i < q.size() / 3; ++i) {
        const Vec3 d = q.segment<3>(3 * i) - center;
        const double distance = d.norm();
        if (distance >= radius) continue;
        contacts.vertices.push_back(i);
        contacts.normals.push_back(distance > 0.0 ? Vec3(d / distance) : Vec3(Vec3::UnitY()));
    }
    return contacts;
}

void velocity_filter_cloth_sphere(VecX& qdot, const SphereContacts& contacts) {
    for (std::size_t k = 0; k < contacts.vertices.size(); ++k) {
        auto v = qdot.segment<3>(3 * contacts.vertices[k]);
        const double inward = contacts.normals[k].dot(v);
        if (inward < 0.0) v -= inward * contacts.normals[k];
    }
}

Pick pick_nearest_vertices(const Vec2& win, const Mat4& view, const Mat4& projection, const Vec2& viewport,
                           VecRef q, const Triangles& F, double radius) {
    const Vec2 ndc = pixel_to_ndc(win, viewport);
    const Mat4 inverse = (projection * view).inverse();
    const Eigen::Vector4d near_plane = inverse * Eigen::Vector4d(ndc.x(), ndc.y(), -1.0, 1.0);
    const Eigen::Vector4d far_plane = inverse * Eigen::Vector4d(ndc.x(), ndc.y(), 1.0, 1.0);
    const Vec3 origin = near_plane.head<3>() / near_plane.w();
    const Vec3 direction = (far_plane.head<3>() / far_plane.w() - origin).normalized();

    double first = std::numeric_limits<double>::infinity();
    int triangle = -1;
    for (int t = 0; t < F.rows(); ++t) {
        const double s = ray_triangle(origin, direction, q.segment<3>(3 * F(t, 0)), q.segment<3>(3 * F(t, 1)),
                                      q.segment<3>(3 * F(t, 2)));
        if (s < first) {
            first = s;
            triangle = t;
        }
    }
    Pick pick;
    if (triangle < 0) return pick;

    pick.hit = origin + first * direction;
    int nearest = F(triangle, 0);
    for (int i = 1; i < 3; ++i) {
        const int v = F(triangle, i);
        if ((q.segment<3>(3 * v) - pick.hit).norm() < (q.segment<3>(3 * nearest) - pick.hit).norm())
            nearest = v;
    }
    pick.vertices.push_back(nearest);
    for (int i = 0; i < q.size() / 3; ++i) {
        if (i != nearest && (q.segment<3>(3 * i) - q.segment<3>(3 * nearest)).norm() <= radius) {
            pick.vertices.push_back(i);
        }
    }
    return pick;
}

Vec3 unproject(const Vec2& win, const Mat4& view, const Mat4& projection, const Vec2& viewport,
               const Vec3& reference) {
    const Vec2 ndc = pixel_to_ndc(win, viewport);
    const Mat4 view_projection = projection * view;
    const Eigen::Vector4d clip = view_projection * reference.homogeneous();
    const double depth = clip.z() / clip.w();
    const Eigen::Vector4d world = view_projection.inverse() * Eigen::Vector4d(ndc.x(), ndc.y(), depth, 1.0);
    return world.head<3>() / world.w();
}

}  // namespace cloth
