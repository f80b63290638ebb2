#include "pipeline/formats/file_io.h"

#include <stdexcept>
#include <system_error>

#include "base/whole_file.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// What `action` returns; its failure as an Error.
template <class Action>
auto told(const Action& action) {
    try {
        return action();
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::other, e.what());
    }
}

}  // namespace

void write_file(const fs::path& path, std::string_view bytes) {
    told([&] { write_whole_file(path, bytes); });
}

std::string read_file(const fs::path& path) {
    return told([&] { return read_whole_file(path); });
}

std::string extension_of(const fs::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return extension;
}

FileSet::~FileSet() {
    for (const fs::path& path : unfinished_) discard_part(path);
}

void FileSet::write(const fs::path& path, std::string_view bytes) {
    // Told of now, not when the files before it have their names.
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        throw Error(ExitCode::other, "cannot write " + path.string() + ": Is a directory");
    told([&] { write_part(path, bytes); });
    unfinished_.push_back(path);
}

void FileSet::finish() {
    for (const fs::path& path : unfinished_) told([&] { finish_part(path); });
    unfinished_.clear();
}

}  // namespace cloth::pipeline
