#include "pipeline/formats/file_io.h"

#include <algorithm>
#include <fstream>
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

GrowingFile::GrowingFile(const fs::path& path) : file_(told([&] { return PartFile(path); })) {}

void GrowingFile::write(std::string_view bytes) {
    told([&] { file_.write(bytes); });
    size_ += bytes.size();
}

void GrowingFile::write(GrowingFile&& other) {
    const GrowingFile taken = std::move(other);
    taken.read_back([&](std::string_view bytes) { write(bytes); });
}

void GrowingFile::read_back(const std::function<void(std::string_view)>& take) const {
    std::ifstream in(part(), std::ios::binary);
    std::string block(std::size_t{1} << 22, '\0');
    std::uint64_t left = size_;
    while (left > 0) {
        in.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(left, block.size())));
        const auto got = static_cast<std::size_t>(in.gcount());
        if (got == 0) throw Error(ExitCode::other, "cannot read " + part().string());
        take(std::string_view(block).substr(0, got));
        left -= got;
    }
}

void GrowingFile::finish() {
    told([&] { file_.finish(); });
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
