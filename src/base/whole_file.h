#pragma once
// Whole files in and out. A file appears under its name complete or not at all.

#include <filesystem>
#include <string>
#include <string_view>

namespace cloth {

/// Writes `path`.part, then renames; on failure removes it and throws std::runtime_error naming path and
/// cause.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);
/// Throws std::runtime_error naming path and cause.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace cloth
