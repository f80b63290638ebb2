#include "sim/energies/air.h"

#include <cmath>
#include <random>

#include "base/portable_math.h"

namespace cloth {
namespace {

constexpr double degrees_per_radian = 57.295779513082320877;

std::vector<std::array<int, 3>> corners(const Triangles& triangles) {
    std::vector<std::array<int, 3>> list;
    for (int t = 0; t < triangles.rows(); ++t)
        list.push_back({triangles(t, 0), triangles(t, 1), triangles(t, 2)});
    return list;
}

}  // namespace

Wind::Wind(const AirDesc& air) : mean_(air.wind) {
    if (air.gusts == 0.0) return;
    constexpr int count = 16;
    std::mt19937 random(air.seed);
    // The library's distributions differ between implementations; the generator's bits do not.
    auto uniform = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
    auto direction = [&] {
        Vec3 d;
        do {
            for (int a = 0; a < 3; ++a) d(a) = 2.0 * uniform() - 1.0;
        } while (d.squaredNorm() > 1.0 || d.squaredNorm() < 0.01);
        return Vec3(d.normalized());
    };
    // A wave of amplitude a adds a²/2 over three components.
    const double amplitude = air.gusts * std::sqrt(6.0 / count);
    for (int i = 0; i < count; ++i) {
        const double length = air.gust_length * (0.25 + 0.75 * uniform());
        const Vec3 k = 360.0 / length * direction();
        Vec3 across;
        do across = direction() - k * (k.dot(direction()) / k.squaredNorm());
        while (across.cross(k).norm() < 0.1 * k.norm());
        across -= k * (k.dot(across) / k.squaredNorm());
        waves_.push_back(
            {k, amplitude * across.normalized(), k.norm() * air.gusts - k.dot(air.wind), 360.0 * uniform()});
    }
}

Vec3 Wind::at(const Vec3& place, double time) const {
    Vec3 velocity = mean_;
    for (const Wave& wave : waves_) {
        velocity +=
            cos_degrees(wave.per_metre.dot(place) + wave.per_second * time + wave.phase) * wave.direction;
    }
    return velocity;
}

AirEnergy::AirEnergy(const Triangles& triangles, const AirDesc& air)
    : elements_(corners(triangles)),
      air_(air),
      wind_field_(air),
      B_(triangles.rows(), Mat3::Zero()),
      wind_(triangles.rows(), Vec3::Zero()) {}

void AirEnergy::begin(const Stage& stage) {
    h_ = stage.h;
    base_ = stage.base();
    parallel_for(elements_.count(), [&](int t) {
        const auto& v = elements_.stencil(t);
        const VecX& x = stage.past.front().positions;
        const Vec3 x0 = x.segment<3>(3 * v[0]), x1 = x.segment<3>(3 * v[1]), x2 = x.segment<3>(3 * v[2]);
        const Vec3 area_normal = (x1 - x0).cross(x2 - x0);
        const double area = 0.5 * area_normal.norm();
        wind_[t] = wind_field_.at((x0 + x1 + x2) / 3.0, stage.time);
        const Vec3 velocity =
            (stage.state.velocities.segment<3>(3 * v[0]) + stage.state.velocities.segment<3>(3 * v[1]) +
             stage.state.velocities.segment<3>(3 * v[2])) /
            3.0;
        const Vec3 u = wind_[t] - velocity;
        const double speed = u.norm();
        if (!(speed > 0.0) || !(area > 0.0)) {
            B_[t].setZero();
            return;
        }
        const Vec3 n = area_normal.normalized();
        const double through = std::abs(n.dot(u));
        B_[t] = 0.5 * air_.density * area *
                (air_.lift * speed * n * n.transpose() +
                 (air_.drag * through - air_.lift * through * through / speed) * Mat3::Identity());
    });
}

Vec3 AirEnergy::relative_wind(const VecX& x, int t) const {
    const Vec9 way = elements_.gather(x, t) - elements_.gather(base_, t);
    return wind_[t] - way.reshaped(3, 3).rowwise().sum() / (3.0 * h_);
}

double AirEnergy::value(const VecX& x) const {
    return 0.5 * h_ * elements_.sum([&](int t) {
        const Vec3 u = relative_wind(x, t);
        return u.dot(B_[t] * u);
    });
}

void AirEnergy::add_gradient(const VecX& x, VecX& g) const {
    elements_.add_gradient(g, [&](int t) {
        const Vec3 share = -B_[t] * relative_wind(x, t) / 3.0;
        Vec9 gradient;
        gradient << share, share, share;
        return gradient;
    });
}

void AirEnergy::add_hessian(const VecX&, HessianKind, BlockMatrix& H) const {
    elements_.add_hessian(H, [&](int t) -> Mat9 { return (B_[t] / (9.0 * h_)).replicate<3, 3>(); });
}

}  // namespace cloth
