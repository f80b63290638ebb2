#include "sim/motion/pins.h"

#include <algorithm>

#include "sim/scene/mesh.h"

namespace cloth {

MotionKey motion_at(const std::vector<MotionKey>& path, double time) {
    if (path.empty()) return {};
    if (time <= path.front().time) return path.front();
    for (std::size_t k = 1; k < path.size(); ++k) {
        if (time > path[k].time) continue;
        const MotionKey &a = path[k - 1], &b = path[k];
        const double share = (time - a.time) / (b.time - a.time);
        return {time, a.translate + share * (b.translate - a.translate),
                a.rotate + share * (b.rotate - a.rotate)};
    }
    return path.back();
}

std::vector<Vec3> PinGroup::places(double time) const {
    if (carrier) return carrier->places(time);
    if (path.empty()) return start;
    const MotionKey key = motion_at(path, time);
    const Mat3 R = rotation_matrix(key.rotate);
    std::vector<Vec3> all;
    for (const Vec3& p : start) all.push_back(center + R * (p - center) + key.translate);
    return all;
}

std::vector<Pin> pins_of_step(const std::vector<PinGroup>& groups, double start, double end) {
    constexpr double slack = 1e-9;  // a pin that lets go at 0.3 misses the step from 0.29999999999999998
    std::vector<Pin> pins;
    for (const PinGroup& group : groups) {
        if (group.until && start >= *group.until - slack) continue;
        const std::vector<Vec3> places = group.places(end);
        for (std::size_t i = 0; i < places.size(); ++i) pins.push_back({group.vertices[i], places[i]});
    }
    std::stable_sort(pins.begin(), pins.end(),
                     [](const Pin& a, const Pin& b) { return a.vertex < b.vertex; });
    pins.erase(std::unique(pins.begin(), pins.end(),
                           [](const Pin& a, const Pin& b) { return a.vertex == b.vertex; }),
               pins.end());
    return pins;
}

Vec3 Hold::place(double time) const {
    if (time >= end || !(end > begin)) return to;
    const double share = std::max(0.0, (time - begin) / (end - begin));
    return from + share * (to - from);
}

void add_holds(std::vector<Pin>& pins, const std::vector<Hold>& holds, double time) {
    if (holds.empty()) return;
    std::vector<Pin> all;
    for (const Hold& hold : holds) all.push_back({hold.vertex, hold.place(time)});
    all.insert(all.end(), pins.begin(), pins.end());
    std::stable_sort(all.begin(), all.end(), [](const Pin& a, const Pin& b) { return a.vertex < b.vertex; });
    all.erase(
        std::unique(all.begin(), all.end(), [](const Pin& a, const Pin& b) { return a.vertex == b.vertex; }),
        all.end());
    pins = std::move(all);
}

void zero_pinned(const std::vector<Pin>& pins, VecX& v) {
    for (const Pin& pin : pins) v.segment<3>(3 * pin.vertex).setZero();
}

void place_pinned(const std::vector<Pin>& pins, VecX& x) {
    for (const Pin& pin : pins) x.segment<3>(3 * pin.vertex) = pin.position;
}

void set_pinned_way(const std::vector<Pin>& pins, const VecX& x, VecX& way) {
    for (const Pin& pin : pins) {
        way.segment<3>(3 * pin.vertex) = pin.position - x.segment<3>(3 * pin.vertex);
    }
}

bool pins_placed(const std::vector<Pin>& pins, const VecX& x) {
    return std::all_of(pins.begin(), pins.end(),
                       [&](const Pin& pin) { return x.segment<3>(3 * pin.vertex) == pin.position; });
}

}  // namespace cloth
