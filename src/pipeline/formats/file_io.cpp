#include "pipeline/formats/file_io.h"

#include <stdexcept>
#include <system_error>
#include <utility>

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

void write_file(const fs::path& path, std::string_view bytes, Sync sync) {
    told([&] { write_whole_file(path, bytes, sync); });
}

void write_if_changed(const fs::path& path, std::string_view bytes) {
    std::error_code failure;
    if (fs::is_regular_file(fs::symlink_status(path, failure)) &&
        fs::file_size(path, failure) == bytes.size() && !failure && read_file(path) == bytes)
        return;
    write_file(path, bytes);
}

std::string read_file(const fs::path& path) {
    return told([&] { return read_whole_file(path); });
}

std::string extension_of(const fs::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return extension;
}

void FileSet::write(const fs::path& path, std::string_view bytes) {
    told([&] {
        PartFile file(path);
        file.write(bytes);
        unfinished_.push_back(std::move(file));
    });
}

void FileSet::finish() {
    for (PartFile& file : unfinished_) told([&] { file.finish(); });
    unfinished_.clear();
}

}  // namespace cloth::pipeline
