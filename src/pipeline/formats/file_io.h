#pragma once
// Whole files in and out, and their names. A file appears under its name complete or not at all.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cloth::pipeline {

/// Writes `path`.part, then renames; on failure removes it and throws Error(other) naming path and cause.
void write_file(const std::filesystem::path& path, std::string_view bytes);
/// Throws Error(other) naming path and cause.
std::string read_file(const std::filesystem::path& path);

/// ".obj" of sheet.OBJ: in lower case, with its dot; empty where there is none.
std::string extension_of(const std::filesystem::path& path);

/// Files that appear under their names together, once all of them are written.
class FileSet {
  public:
    FileSet() = default;
    FileSet(const FileSet&) = delete;
    FileSet& operator=(const FileSet&) = delete;
    ~FileSet();  ///< without finish(): removes what was written

    /// Writes `path`.part. Throws Error(other) naming path and cause.
    void write(const std::filesystem::path& path, std::string_view bytes);
    /// Renames all. Throws Error(other) naming path and cause; what has its name by then keeps it.
    void finish();

  private:
    std::vector<std::filesystem::path> unfinished_;
};

}  // namespace cloth::pipeline
