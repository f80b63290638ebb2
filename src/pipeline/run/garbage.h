#pragma once
// Files in the folders of runs that no run needs.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cloth::pipeline {

struct Garbage {
    std::filesystem::path file;
    std::uintmax_t bytes = 0;
    std::string why;
};

/// Folders at or below `folder` that hold a run, sorted.
std::vector<std::filesystem::path> runs_below(const std::filesystem::path& folder);

/// In one run: frames behind its last, states and pictures that are damaged or made from something else, and
/// what a killed program left. The folder must not be written to meanwhile.
std::vector<Garbage> garbage_of(const std::filesystem::path& run);

}  // namespace cloth::pipeline
