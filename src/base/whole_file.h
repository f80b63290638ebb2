#pragma once
// Whole files in and out. A file appears under its name complete or not at all.

#include <filesystem>
#include <string>
#include <string_view>

namespace cloth {

/// Writes `path`.part, then renames; on failure removes it and throws std::runtime_error naming path and
/// cause.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

/// The two halves of write_whole_file(), for files that belong together. Each throws as it does.
void write_part(const std::filesystem::path& path, std::string_view bytes);
void finish_part(const std::filesystem::path& path);
/// In place of finish_part(): removes `path`.part where there is one.
void discard_part(const std::filesystem::path& path);

/// Throws std::runtime_error naming path and cause.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace cloth
