#pragma once
// Whole files in and out. A file appears under its name complete or not at all.

#include <filesystem>
#include <string>
#include <string_view>

namespace cloth::pipeline {

/// Writes `path`.part, then renames; on failure removes it and throws Error(other) naming path and cause.
void write_file(const std::filesystem::path& path, std::string_view bytes);
/// Throws Error(other) naming path and cause.
std::string read_file(const std::filesystem::path& path);

}  // namespace cloth::pipeline
