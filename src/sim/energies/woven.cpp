#include "sim/energies/woven.h"

#include "sim/algebra/rest_frame.h"
#include "sim/algebra/symmetric.h"

namespace cloth {
namespace {

Mat32 deformation(const WovenRest& rest, const Vec9& q9) {
    // Differences first: a sheet far from the origin loses no digits.
    const Mat3 q = q9.reshaped(3, 3);
    return (q.col(1) - q.col(0)) * rest.b.row(1) + (q.col(2) - q.col(0)) * rest.b.row(2);
}

Vec3 strain(const Mat32& G) {
    return {0.5 * (G.col(0).squaredNorm() - 1.0), 0.5 * (G.col(1).squaredNorm() - 1.0),
            G.col(0).dot(G.col(1))};
}

}  // namespace

Mat3 woven_stiffness(double young_warp, double young_weft, double poisson, double shear) {
    const double r = young_weft / young_warp, scale = young_warp / (1.0 - poisson * poisson * r);
    Mat3 C;
    C << scale, poisson * r * scale, 0.0, poisson * r * scale, r * scale, 0.0, 0.0, 0.0, shear;
    return C;
}

WovenRest make_woven_rest(const Vec3& X0, const Vec3& X1, const Vec3& X2, const Vec3& warp, double thickness,
                          const Mat3& C) {
    const RestFrame frame = make_rest_frame(X0, X1, X2, warp);
    return {shape_gradients(frame, X0, X1, X2), frame.area * thickness, C};
}

Vec3 green_strain(const WovenRest& rest, const Vec9& q9) {
    return strain(deformation(rest, q9));
}

double woven_energy(const WovenRest& rest, const Vec3& from, const Vec9& q9) {
    const Vec3 e = green_strain(rest, q9) - from;
    return 0.5 * rest.volume * e.dot(rest.C * e);
}

Vec9 woven_gradient(const WovenRest& rest, const Vec3& from, const Vec9& q9) {
    const Mat32 G = deformation(rest, q9);
    const Vec3 s = rest.C * (strain(G) - from);
    Mat2 S;
    S << s(0), s(2), s(2), s(1);
    Vec9 gradient;
    gradient.reshaped(3, 3).noalias() = rest.volume * (G * (S * rest.b.transpose()));
    return gradient;
}

Mat9 woven_hessian(const WovenRest& rest, const Vec3& from, const Vec9& q9, bool project) {
    const Mat32 G = deformation(rest, q9);
    const Vec3 s = rest.C * (strain(G) - from);
    Mat2 S;
    S << s(0), s(2), s(2), s(1);
    if (project) S = positive_part(S);
    const Mat3 bSb = rest.b * S * rest.b.transpose();
    std::array<Mat3, 3> B;  // rows: derivatives of e by the corner
    for (int i = 0; i < 3; ++i) {
        B[i].row(0) = rest.b(i, 0) * G.col(0).transpose();
        B[i].row(1) = rest.b(i, 1) * G.col(1).transpose();
        B[i].row(2) = (rest.b(i, 0) * G.col(1) + rest.b(i, 1) * G.col(0)).transpose();
    }
    Mat9 H;
    for (int j = 0; j < 3; ++j) {
        const Mat3 CB = rest.C * B[j];
        for (int i = 0; i <= j; ++i) {
            Mat3 block = B[i].transpose() * CB;
            block.diagonal().array() += bSb(i, j);
            H.block<3, 3>(3 * i, 3 * j) = rest.volume * block;
            if (i != j) H.block<3, 3>(3 * j, 3 * i) = H.block<3, 3>(3 * i, 3 * j).transpose();
        }
    }
    return H;
}

WovenEnergy::WovenEnergy(std::vector<std::array<int, 3>> triangles, std::vector<WovenRest> rest)
    : elements_(std::move(triangles)), rest_(std::move(rest)) {}

double WovenEnergy::value(const VecX& x) const {
    return elements_.sum([&](int t) { return woven_energy(rest_[t], Vec3::Zero(), elements_.gather(x, t)); });
}

void WovenEnergy::add_gradient(const VecX& x, VecX& g) const {
    elements_.add_gradient(
        g, [&](int t) { return woven_gradient(rest_[t], Vec3::Zero(), elements_.gather(x, t)); });
}

void WovenEnergy::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    elements_.add_hessian(H, [&](int t) {
        return woven_hessian(rest_[t], Vec3::Zero(), elements_.gather(x, t), kind != HessianKind::exact);
    });
}

MembraneViscosity::MembraneViscosity(std::vector<std::array<int, 3>> triangles, std::vector<WovenRest> rest)
    : elements_(std::move(triangles)), rest_(std::move(rest)), base_(rest_.size(), Vec3::Zero()) {}

void MembraneViscosity::begin(const Stage& stage) {
    h_ = stage.h;
    parallel_for(elements_.count(), [&](int t) {
        base_[t].setZero();
        for (const Stage::Past& past : stage.past) {
            base_[t] += past.share * green_strain(rest_[t], elements_.gather(past.positions, t));
        }
    });
}

double MembraneViscosity::value(const VecX& x) const {
    return elements_.sum([&](int t) { return woven_energy(rest_[t], base_[t], elements_.gather(x, t)); }) /
           h_;
}

void MembraneViscosity::add_gradient(const VecX& x, VecX& g) const {
    elements_.add_gradient(
        g, [&](int t) -> Vec9 { return woven_gradient(rest_[t], base_[t], elements_.gather(x, t)) / h_; });
}

void MembraneViscosity::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    elements_.add_hessian(H, [&](int t) -> Mat9 {
        return woven_hessian(rest_[t], base_[t], elements_.gather(x, t), kind != HessianKind::exact) / h_;
    });
}

}  // namespace cloth
