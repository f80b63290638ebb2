#include "pipeline/picture/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cloth::pipeline {
namespace {

constexpr double radians = std::numbers::pi / 180.0;
constexpr double spare = 1.0 / 12.0;  // of the picture, on each side

/// Slope at the middle one of three keys.
double slope(double before, double after, double secant_before, double secant_after) {
    if (secant_before * secant_after <= 0.0) return 0.0;
    const double w1 = 2.0 * after + before, w2 = after + 2.0 * before;
    return (w1 + w2) / (w1 / secant_before + w2 / secant_after);
}

double along(const std::vector<double>& times, const std::vector<double>& values, double time) {
    if (time <= times.front()) return values.front();
    if (time >= times.back()) return values.back();
    const std::size_t i =
        static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin()) - 1;
    const auto secant = [&](std::size_t k) {
        return (values[k + 1] - values[k]) / (times[k + 1] - times[k]);
    };
    const auto slope_at = [&](std::size_t k) {
        if (k == 0 || k + 1 == times.size()) return 0.0;
        return slope(times[k] - times[k - 1], times[k + 1] - times[k], secant(k - 1), secant(k));
    };
    const double h = times[i + 1] - times[i], s = (time - times[i]) / h;
    return values[i] * (1 + 2 * s) * (1 - s) * (1 - s) + h * slope_at(i) * s * (1 - s) * (1 - s) +
           values[i + 1] * s * s * (3 - 2 * s) + h * slope_at(i + 1) * s * s * (s - 1);
}

Mat3 camera_axes(const CameraDesc& camera) {
    Mat3 axes;
    const Vec3 forward = (camera.target - camera.position).normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    axes << right.transpose(), right.cross(forward).transpose(), forward.transpose();
    return axes;
}

/// Evenly spread over the sphere, along a spiral of golden angles.
const std::vector<Vec3>& directions() {
    static const std::vector<Vec3> list = [] {
        constexpr int count = 128;
        std::vector<Vec3> made;
        for (int i = 0; i < count; ++i) {
            const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
            const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
            made.emplace_back(r * std::cos(angle), z, r * std::sin(angle));
        }
        return made;
    }();
    return list;
}

render::Float3 to_float(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

CameraPose camera_at(const CameraDesc& camera, double time) {
    CameraPose pose{camera.position, camera.target, camera.field_of_view};
    if (!camera.path.empty()) {
        std::vector<double> times, values(camera.path.size());
        for (const CameraKey& key : camera.path) times.push_back(key.time);
        const auto follow = [&](const auto& value_of) {
            std::transform(camera.path.begin(), camera.path.end(), values.begin(), value_of);
            return along(times, values, time);
        };
        for (int i = 0; i < 3; ++i) {
            pose.position(i) =
                follow([&](const CameraKey& k) { return k.position.value_or(camera.position)(i); });
            pose.target(i) = follow([&](const CameraKey& k) { return k.target.value_or(camera.target)(i); });
        }
        pose.field_of_view =
            follow([&](const CameraKey& k) { return k.field_of_view.value_or(camera.field_of_view); });
    }
    if (camera.turntable != 0.0) {
        const Eigen::AngleAxisd turn(camera.turntable * radians * time, camera.up.normalized());
        pose.position = pose.target + turn * (pose.position - pose.target);
    }
    return pose;
}

bool moves(const CameraDesc& camera) {
    return !camera.path.empty() || camera.turntable != 0.0;
}

void aim(render::View& view, const CameraDesc& camera, double time) {
    const CameraPose pose = camera_at(camera, time);
    view.eye = to_float(pose.position);
    view.target = to_float(pose.target);
    view.up = to_float(camera.up);
    view.field_of_view = static_cast<float>(pose.field_of_view);
}

Extent::Extent(const CameraDesc& camera, double aspect)
    : axes_(camera_axes(camera)), turns_(camera.turntable != 0.0) {
    const double half_height = (1.0 - 2.0 * spare) * std::tan(0.5 * camera.field_of_view * radians);
    slopes_ = Vec2(half_height * aspect, half_height);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    low_.setConstant(infinity);
    high_.setConstant(-infinity);
    most_.setConstant(-infinity);
    least_.setConstant(-infinity);
}

void Extent::add(const Vec3& point) {
    if (turns_ && furthest_.empty()) furthest_.assign(directions().size(), point);
    for (std::size_t i = 0; i < furthest_.size(); ++i)
        if (directions()[i].dot(point - furthest_[i]) > 0.0) furthest_[i] = point;
    low_ = low_.cwiseMin(point);
    high_ = high_.cwiseMax(point);
    const Vec3 p = axes_ * point;
    most_ = most_.cwiseMax(p.head<2>() - slopes_ * p.z());
    least_ = least_.cwiseMax(-p.head<2>() - slopes_ * p.z());
}

void Extent::add(const Extent& other) {
    for (const Vec3& point : other.furthest_) add(point);
    low_ = low_.cwiseMin(other.low_);
    high_ = high_.cwiseMax(other.high_);
    most_ = most_.cwiseMax(other.most_);
    least_ = least_.cwiseMax(other.least_);
}

CameraDesc Extent::framed(const CameraDesc& camera) const {
    CameraDesc result = camera;
    if (empty()) return result;
    const Vec3 forward = axes_.row(2), middle = 0.5 * (low_ + high_);
    // Something to look at, however small.
    const double radius = std::max(0.5 * diagonal(), 1e-3);
    if (camera.turntable != 0.0) {
        // Seen from the distance d, a point is in the picture where |x| <= slope (z + d).
        double distance = 1e-3;
        constexpr int turns = 180;
        for (int k = 0; k < turns; ++k) {
            const double angle = 2.0 * std::numbers::pi * k / turns;
            const Mat3 back = Eigen::AngleAxisd(angle, camera.up.normalized()).toRotationMatrix();
            for (const Vec3& point : furthest_) {
                const Vec3 p = axes_ * (back * (point - middle));
                const double needed = p.head<2>().cwiseAbs().cwiseQuotient(slopes_).maxCoeff() - p.z();
                distance = std::max({distance, needed, -1.05 * p.z()});
            }
        }
        result.target = middle;
        result.position = middle - distance * forward;
        return result;
    }
    // A point is in the picture where |x - ex| <= slope (z - ez). Two such bounds give ex in the middle, and
    // the tighter of the two pairs gives ez.
    const Vec2 across = 0.5 * (most_ - least_), depth = -0.5 * (most_ + least_).cwiseQuotient(slopes_);
    const double nearest = middle.dot(forward) - radius;  // and never among the points
    const Vec3 eye(across.x(), across.y(), std::min(depth.minCoeff(), nearest));
    result.position = axes_.transpose() * eye;
    result.target = result.position + (middle.dot(forward) - eye.z()) * forward;
    return result;
}

}  // namespace cloth::pipeline
