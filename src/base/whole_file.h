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
    /// Until the bytes written so far are on the disk itself, so that no power cut leaves a cut file under
    /// the name that finish() gives.
    void sync() const;
    void finish();

  private:
    std::filesystem::path target_;
    bool stream_ = false;  ///< the target is a device or a pipe
    FileToRemove part_;
};

/// "state_000012.bin" for a name that its part may have; empty for other names. A killed program leaves
/// parts.
std::string target_of_part(const std::string& name);

/// Whether the disk has a file's bytes before it has its name.
enum class Sync { no, yes };

/// A PartFile with `bytes`, finished.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes, Sync sync = Sync::no);

/// Lines at the end of a file, which is made where it is missing. Whole lines, unless the program is killed
/// or the disk is full: then the last may be cut. Throws std::runtime_error naming path and cause.
class LineFile {
  public:
    explicit LineFile(const std::filesystem::path& path);
    LineFile(const LineFile&) = delete;
    LineFile& operator=(const LineFile&) = delete;
    ~LineFile();
    /// Adds `line` and its end.
    void add(const std::string& line, Sync sync);

  private:
    std::filesystem::path path_;
    int file_ = -1;
};

/// Throws std::runtime_error naming path and cause: what is no regular file (a pipe or device may never end),
/// or larger than the memory that is there, is refused.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace cloth
