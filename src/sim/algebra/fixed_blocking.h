#pragma once
// The same sums on every processor. Internal.

#include <Eigen/Core>

namespace cloth {

/// Eigen cuts the inner sums of large dense products to what fits into the processor's caches, which it asks
/// for their sizes: without this, states have other last bits where the first-level cache has 32 KiB instead
/// of 48. Here it is told sizes, whatever there is. Sets them for the process.
inline void fix_blocking() {
    constexpr std::ptrdiff_t level_1 = 48 << 10, level_2 = 2 << 20, level_3 = 32 << 20;
    if (Eigen::l1CacheSize() != level_1 || Eigen::l2CacheSize() != level_2 || Eigen::l3CacheSize() != level_3)
        Eigen::setCpuCacheSizes(level_1, level_2, level_3);
}

}  // namespace cloth
