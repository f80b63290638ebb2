#pragma once
// Work that may crash, hang or eat memory, in a process of its own.

#include <cstddef>
#include <functional>
#include <string>

namespace cloth {

struct ChildLimits {
    int seconds = 60;        ///< of processor time; on the clock twice as long [s]
    std::size_t memory = 0;  ///< beyond what this process has [byte]; 0: all; without effect under sanitizers
};

/// What `work` returns in a child of this process: nothing that it does is seen here, and it prints nothing.
/// Throws std::runtime_error: what `work` threw, or "ended with signal 11", "took longer than 60 s", "needs
/// more memory than 2.0 GB". `work` runs beside no other thread, so that it must not wait for one.
std::string in_child(const std::function<std::string()>& work, const ChildLimits& limits = {});

}  // namespace cloth
