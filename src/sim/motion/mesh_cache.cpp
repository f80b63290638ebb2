#include "sim/motion/mesh_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/scene/mesh.h"

namespace cloth {
namespace {

/// Of frame k since the first [s].
double time_of(const ColliderDesc& collider, std::size_t k) {
    const MeshCache& cache = *collider.cache;
    if (!collider.cache_rate && !cache.times.empty()) return cache.times[k] - cache.times[0];
    return static_cast<double>(k) / collider.cache_rate.value_or(usual_cache_rate);
}

/// Between frames a and b.
struct Between {
    std::size_t a, b;
    double share;  ///< of b
};

Between between(const ColliderDesc& collider, double time) {
    const MeshCache& cache = *collider.cache;
    const std::size_t last = cache.frames.size() - 1;
    double at = (time - collider.cache_start) * collider.cache_speed;
    if (last == 0 || !(at > 0.0)) return {0, 0, 0.0};
    const double end = time_of(collider, last);
    if (collider.cache_loop) {
        // One that ends where it began repeats from there; else the last frame goes on to the first.
        const bool closed = cache.frames[last] == cache.frames[0];
        const double back = closed ? 0.0 : end - time_of(collider, last - 1);
        at = std::fmod(at, end + back);
        if (at > end) return {last, 0, (at - end) / back};
    }
    if (at >= end) return {last, last, 0.0};
    // The first frame later than `at`.
    std::size_t low = 0, high = last;
    while (high - low > 1) {
        const std::size_t middle = low + (high - low) / 2;
        (time_of(collider, middle) > at ? high : low) = middle;
    }
    const double begin = time_of(collider, low);
    return {low, high, (at - begin) / (time_of(collider, high) - begin)};
}

}  // namespace

Points cached_vertices(const ColliderDesc& collider, double time) {
    const auto [a, b, share] = between(collider, time);
    const Points &from = collider.cache->frames[a], &to = collider.cache->frames[b];
    const Mat3 R = rotation_matrix(collider.rotate);
    const double scale = collider.scale * length_of(collider.units);
    Points places(from.rows(), 3);
    for (Eigen::Index v = 0; v < places.rows(); ++v) {
        const Vec3 p = from.row(v) + share * (to.row(v) - from.row(v));
        places.row(v) = (collider.center + R * (scale * p)).transpose();
    }
    return places;
}

double cache_end(const ColliderDesc& collider) {
    if (collider.cache_loop) return std::numeric_limits<double>::infinity();
    return collider.cache_start + time_of(collider, collider.cache->frames.size() - 1) / collider.cache_speed;
}

}  // namespace cloth
