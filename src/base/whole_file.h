#pragma once
// Whole files in and out: the one place that writes files. A file appears under its name complete or not at
// all.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace cloth {

/// A file that must not outlive this, nor the program: remove_noted_files() knows of it.
class FileToRemove {
  public:
    explicit FileToRemove(std::filesystem::path path = {});
    FileToRemove(FileToRemove&& other) noexcept : path_(std::exchange(other.path_, {})) {}
    FileToRemove& operator=(FileToRemove&& other) noexcept {
        std::swap(path_, other.path_);
        return *this;
    }
    ~FileToRemove();  ///< removes it, unless kept
    void keep();
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// For one who ends the program at once: removes all files that were noted. No other can be noted after it.
void remove_noted_files();

/// A file in the making. Its bytes lie beside `target`, under a name that no other program takes, until
/// finish() gives them theirs. In place of what is no regular file nothing appears: a device or a pipe is
/// written to in finish(), and a link, which may lead anywhere, is refused. Throws std::runtime_error naming
/// `target` and the cause.
class PartFile {
  public:
    explicit PartFile(std::filesystem::path target);
    PartFile(PartFile&&) noexcept = default;
    PartFile& operator=(PartFile&&) noexcept = default;

    /// Where the bytes are until finish(): an empty file at first, for others to fill.
    const std::filesystem::path& part() const { return part_.path(); }
    void write(std::string_view bytes);
    void finish();

  private:
    std::filesystem::path target_;
    bool stream_ = false;  ///< the target is a device or a pipe
    FileToRemove part_;
};

/// "state_000012.bin" for a name that its part may have; empty for other names. A killed program leaves
/// parts.
std::string target_of_part(const std::string& name);

/// A PartFile with `bytes`, finished.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

/// Throws std::runtime_error naming path and cause: what is no regular file (a pipe or device may never end),
/// or larger than the memory that is there, is refused.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace cloth
