#include "base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

namespace cloth {
namespace {

constexpr std::size_t without_limit = std::numeric_limits<std::size_t>::max();

/// The number behind a word of a file such as /proc/meminfo; `without_limit` where there is none.
std::size_t number_in(const char* path, const std::string& word) {
    std::ifstream file(path);
    for (std::string each; file >> each;) {
        std::size_t number = 0;
        if (each == word && file >> number) return number;
    }
    return without_limit;
}

std::size_t first_number(const char* path) {
    std::ifstream file(path);
    std::size_t number = 0;
    return file >> number ? number : without_limit;  // "max" is none
}

std::size_t less(std::size_t limit, std::size_t used) {
    return limit == without_limit ? limit : limit - std::min(limit, used);
}

}  // namespace

std::size_t address_space() {
    const std::size_t pages = first_number("/proc/self/statm");
    return pages == without_limit ? 0 : pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

std::size_t available_memory() {
    const std::size_t kilobytes = number_in("/proc/meminfo", "MemAvailable:");
    std::size_t least = kilobytes == without_limit ? kilobytes : kilobytes * 1024;
    // In a container the files of its own control group stand at the root.
    const std::size_t group = first_number("/sys/fs/cgroup/memory.max");
    if (group != without_limit) {
        // What is only cache can be had back.
        const std::size_t cache = number_in("/sys/fs/cgroup/memory.stat", "inactive_file");
        const std::size_t used = first_number("/sys/fs/cgroup/memory.current");
        least = std::min(least, less(group, less(used, cache == without_limit ? 0 : cache)));
    }
    rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        least = std::min(least, less(static_cast<std::size_t>(limit.rlim_cur), address_space()));
    return least;
}

std::string memory_text(double bytes) {
    const bool large = bytes >= 0.95e9;
    char text[32];
    std::snprintf(text, sizeof text, large && bytes < 99.5e9 ? "%.1f %s" : "%.0f %s",
                  bytes / (large ? 1e9 : 1e6), large ? "GB" : "MB");
    return text;
}

}  // namespace cloth
