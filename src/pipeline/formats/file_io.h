#pragma once
// Whole files in and out (base/whole_file.h), and their names. What goes wrong is an Error.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/whole_file.h"

namespace cloth::pipeline {

/// As write_whole_file(). Throws Error(other) naming path and cause.
void write_file(const std::filesystem::path& path, std::string_view bytes, Sync sync = Sync::no);
/// The same; a file that holds these bytes already is left alone.
void write_if_changed(const std::filesystem::path& path, std::string_view bytes);
/// Throws Error(other) naming path and cause.
std::string read_file(const std::filesystem::path& path);

/// ".obj" of sheet.OBJ: in lower case, with its dot; empty where there is none.
std::string extension_of(const std::filesystem::path& path);

/// A file that grows while others are written, and appears under its name in finish(). Each call throws
/// Error(other) naming `path` and the cause.
class GrowingFile {
  public:
    explicit GrowingFile(const std::filesystem::path& path);
    void write(std::string_view bytes);
    /// All of another one's bytes, which are no longer needed.
    void write(GrowingFile&& other);
    std::uint64_t size() const { return size_; }
    /// Hands on all bytes so far, piece by piece.
    void read_back(const std::function<void(std::string_view)>& take) const;
    /// Where the bytes are until finish().
    const std::filesystem::path& part() const { return file_.part(); }
    void finish();

  private:
    PartFile file_;
    std::uint64_t size_ = 0;
};

/// Files that appear under their names together, once all of them are written.
class FileSet {
  public:
    /// Throws Error(other) naming path and cause.
    void write(const std::filesystem::path& path, std::string_view bytes);
    /// Gives all their names, in the order of write(). Throws Error(other) naming path and cause; what has
    /// its name by then keeps it.
    void finish();

  private:
    std::vector<PartFile> unfinished_;  // removed where they stay so
};

}  // namespace cloth::pipeline
