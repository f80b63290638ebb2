#include "sim/energies/drag.h"

#include "sim/assignment/assignment.h"

namespace cloth {
namespace {

/// The pointer's place at `time`: keys joined by straight lines.
Vec2 pointer_at(const std::vector<DragDesc::Key>& path, double time) {
    if (time <= path.front().time) return path.front().pixel;
    for (std::size_t k = 1; k < path.size(); ++k) {
        if (time > path[k].time) continue;
        const double s = (time - path[k - 1].time) / (path[k].time - path[k - 1].time);
        return (1.0 - s) * path[k - 1].pixel + s * path[k].pixel;
    }
    return path.back().pixel;
}

/// Times are compared with this slack, so that a key at 0.3 meets the step that starts at
/// 0.29999999999999998.
constexpr double time_slack = 1e-9;

}  // namespace

void update_drags(const std::vector<DragDesc>& drags, double time, const VecX& positions,
                  const Triangles& triangles, std::vector<DragState>& states) {
    for (std::size_t d = 0; d < drags.size(); ++d) {
        const DragDesc& drag = drags[d];
        DragState& state = states[d];
        const bool down =
            time >= drag.path.front().time - time_slack && time < drag.path.back().time - time_slack;
        if (!down) {
            state = {};
        } else if (!state.pressed) {
            const Pick pick = pick_nearest_vertices(drag.path.front().pixel, drag.view, drag.projection,
                                                    drag.viewport, positions, triangles, drag.radius);
            state.pressed = true;
            state.vertices = pick.vertices;
            state.grabbed = pick.hit;
            state.anchors.clear();
            for (int v : pick.vertices) state.anchors.push_back(positions.segment<3>(3 * v));
        }
    }
}

DragEnergy::DragEnergy(const std::vector<DragDesc>& drags, const std::vector<DragState>& states,
                       double time) {
    for (std::size_t d = 0; d < drags.size(); ++d) {
        if (!states[d].pressed || states[d].vertices.empty()) continue;
        const Vec3 pointer = unproject(pointer_at(drags[d].path, time), drags[d].view, drags[d].projection,
                                       drags[d].viewport, states[d].grabbed);
        const Vec3 way = pointer - states[d].grabbed;
        for (std::size_t k = 0; k < states[d].vertices.size(); ++k) {
            springs_.push_back({states[d].vertices[k], states[d].anchors[k] + way, drags[d].stiffness});
        }
    }
}

double DragEnergy::value(const VecX& x) const {
    double sum = 0.0;
    for (const Spring& s : springs_) {
        sum += V_spring_particle_particle(s.target, x.segment<3>(3 * s.vertex), 0.0, s.stiffness);
    }
    return sum;
}

void DragEnergy::add_gradient(const VecX& x, VecX& g) const {
    for (const Spring& s : springs_) {
        g.segment<3>(3 * s.vertex) +=
            dV_spring_particle_particle_dq(s.target, x.segment<3>(3 * s.vertex), 0.0, s.stiffness).tail<3>();
    }
}

void DragEnergy::add_hessian(const VecX&, HessianKind, BlockMatrix& H) const {
    for (std::size_t k = 0; k < springs_.size(); ++k) {
        H.blocks[slots_[k]] += springs_[k].stiffness * Mat3::Identity();
    }
}

void DragEnergy::bind(const BlockPattern& pattern) {
    slots_.clear();
    for (const Spring& s : springs_) slots_.push_back(pattern.diagonal(s.vertex));
}

}  // namespace cloth
