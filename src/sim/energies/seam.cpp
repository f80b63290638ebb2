#include "sim/energies/seam.h"

#include <algorithm>

namespace cloth {

SeamEnergy::SeamEnergy(std::vector<SeamSpring> springs) : springs_(std::move(springs)) {}

double SeamEnergy::rest_length(const SeamSpring& spring) const {
    return spring.length * std::clamp(1.0 - (time_ - spring.begin) / spring.close_time, 0.0, 1.0);
}

double SeamEnergy::value(const VecX& x) const {
    double sum = 0.0;
    for (const SeamSpring& s : springs_) {
        const double stretch = (x.segment<3>(3 * s.a) - x.segment<3>(3 * s.b)).norm() - rest_length(s);
        sum += 0.5 * s.stiffness * stretch * stretch;
    }
    return sum;
}

void SeamEnergy::add_gradient(const VecX& x, VecX& g) const {
    for (const SeamSpring& s : springs_) {
        const Vec3 d = x.segment<3>(3 * s.a) - x.segment<3>(3 * s.b);
        const double distance = d.norm(), l = rest_length(s);
        const Vec3 force =
            l > 0.0 && distance > 0.0 ? Vec3(s.stiffness * (1.0 - l / distance) * d) : Vec3(s.stiffness * d);
        g.segment<3>(3 * s.a) += force;
        g.segment<3>(3 * s.b) -= force;
    }
}

void SeamEnergy::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    for (std::size_t i = 0; i < springs_.size(); ++i) {
        const SeamSpring& s = springs_[i];
        const Vec3 d = x.segment<3>(3 * s.a) - x.segment<3>(3 * s.b);
        const double distance = d.norm(), l = rest_length(s);
        Mat3 block = Mat3::Identity();
        if (l > 0.0 && distance > 0.0) {
            double across = 1.0 - l / distance;
            if (kind != HessianKind::exact) across = std::max(across, 0.0);
            const Vec3 u = d / distance;
            block = across * Mat3::Identity() + (1.0 - across) * u * u.transpose();
        }
        block *= s.stiffness;
        H.blocks[pattern_->diagonal(s.a)] += block;
        H.blocks[pattern_->diagonal(s.b)] += block;
        H.blocks[slots_[i]] -= block;
    }
}

void SeamEnergy::append_pairs(std::vector<std::array<int, 2>>& pairs) const {
    for (const SeamSpring& s : springs_) pairs.push_back({s.a, s.b});
}

void SeamEnergy::bind(const BlockPattern& pattern) {
    pattern_ = &pattern;
    slots_.clear();
    for (const SeamSpring& s : springs_)
        slots_.push_back(pattern.slot(std::min(s.a, s.b), std::max(s.a, s.b)));
}

}  // namespace cloth
