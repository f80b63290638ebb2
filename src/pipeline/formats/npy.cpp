#include "pipeline/formats/npy.h"

#include <fmt/format.h>
#include <minizip/unzip.h>
#include <minizip/zip.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "base/memory.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_draft.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

// ---------------------------------------------------------------- out

namespace {

/// Format 1.0: the magic, the length of a Python dictionary, and that, ending at a multiple of 64 bytes.
std::string npy_header(std::string_view type, const NpzWriter::Shape& shape) {
    std::string sizes;
    for (const std::int64_t size : shape) sizes += fmt::format("{}, ", size);
    std::string words =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sizes);
    words.append(63 - (10 + words.size()) % 64, ' ');
    words += '\n';
    std::string header("\x93NUMPY\x01\x00", 8);
    put(header, static_cast<std::uint16_t>(words.size()));
    return header + words;
}

}  // namespace

NpzWriter::NpzWriter(const fs::path& path, fs::path target)
    : target_(std::move(target)), zip_(::zipOpen64(path.c_str(), APPEND_STATUS_CREATE)) {
    check(zip_ == nullptr ? ZIP_ERRNO : ZIP_OK);
}

NpzWriter::~NpzWriter() {
    if (zip_ != nullptr) ::zipClose(zip_, nullptr);
}

void NpzWriter::check(int result) const {
    if (result != ZIP_OK)
        throw Error(ExitCode::other, "cannot write " + target_.string() + ": no more can be written there");
}

void NpzWriter::begin(const std::string& name, std::string_view type, const Shape& shape) {
    const std::string header = npy_header(type, shape);
    std::uint64_t size = 16;  // of the largest number
    for (const std::int64_t length : shape) size *= static_cast<std::uint64_t>(length);
    zip_fileinfo info{};  // the same bytes whenever they are written
    info.tmz_date = {.tm_sec = 0, .tm_min = 0, .tm_hour = 0, .tm_mday = 1, .tm_mon = 0, .tm_year = 1980};
    check(::zipOpenNewFileInZip64(zip_, (name + ".npy").c_str(), &info, nullptr, 0, nullptr, 0, nullptr, 0, 0,
                                  size >= 0xffff0000u ? 1 : 0));
    write(header);
}

void NpzWriter::write(std::string_view bytes) {
    constexpr std::size_t most = std::size_t{1} << 30;
    while (!bytes.empty()) {
        const std::size_t part = std::min(most, bytes.size());
        check(::zipWriteInFileInZip(zip_, bytes.data(), static_cast<unsigned>(part)));
        bytes.remove_prefix(part);
    }
}

void NpzWriter::end() {
    check(::zipCloseFileInZip(zip_));
}

void NpzWriter::array(const std::string& name, std::string_view type, const Shape& shape,
                      std::string_view bytes) {
    begin(name, type, shape);
    write(bytes);
    end();
}

void NpzWriter::close() {
    check(::zipClose(std::exchange(zip_, nullptr), nullptr));
}

// ---------------------------------------------------------------- in

namespace {

/// What follows `key` in a header's dictionary, up to the next comma that stands outside of brackets.
std::string_view entry_of(std::string_view words, std::string_view key) {
    const std::size_t at = words.find(key);
    if (at == std::string_view::npos) return {};
    words.remove_prefix(at + key.size());
    words.remove_prefix(std::min(words.find_first_not_of(": "), words.size()));
    const std::size_t bracket = words.starts_with('(') ? words.find(')') : 0;
    return words.substr(0, std::min(words.find_first_of(",}", bracket), words.size()));
}

template <class T>
std::vector<double> numbers_from(std::string_view bytes) {
    std::vector<double> numbers(bytes.size() / sizeof(T));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        T value;
        std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
        numbers[i] = static_cast<double>(value);
    }
    return numbers;
}

/// Numbers of a type that NumPy names so; none of one that is not known.
std::vector<double> numbers_of(std::string_view type, std::string_view bytes) {
    if (type == "'<f8'") return numbers_from<double>(bytes);
    if (type == "'<f4'") return numbers_from<float>(bytes);
    if (type == "'<i4'") return numbers_from<std::int32_t>(bytes);
    if (type == "'<u4'") return numbers_from<std::uint32_t>(bytes);
    if (type == "'<i8'") return numbers_from<std::int64_t>(bytes);
    if (type == "'<u8'") return numbers_from<std::uint64_t>(bytes);
    if (type == "'<i2'") return numbers_from<std::int16_t>(bytes);
    if (type == "'<u2'") return numbers_from<std::uint16_t>(bytes);
    return {};
}

NumberArray array_of(std::string_view bytes, const std::string& name, const FilePlace& place) {
    const auto fail = [&](const std::string& what) {
        place.fail(fmt::format("its array {} {}", name, what));
    };
    if (bytes.size() < 12 || !bytes.starts_with("\x93NUMPY")) fail("is no .npy");
    const bool longer = bytes[6] != 1;  // format 2 has a length of four bytes
    std::size_t length = 0;
    for (int i = longer ? 3 : 1; i >= 0; --i) length = length << 8 | static_cast<unsigned char>(bytes[8 + i]);
    const std::size_t begin = longer ? 12 : 10;
    if (length > bytes.size() - begin) fail("is cut short");
    const std::string_view words = bytes.substr(begin, length), body = bytes.substr(begin + length);
    NumberArray array;
    std::string_view shape = entry_of(words, "'shape'");
    double count = 1.0;
    while (!shape.empty()) {
        shape.remove_prefix(std::min(shape.find_first_of("0123456789"), shape.size()));
        if (shape.empty()) break;
        std::int64_t size = 0;
        const auto [end, problem] = std::from_chars(shape.data(), shape.data() + shape.size(), size);
        if (problem != std::errc()) fail("has a shape that is none");
        shape.remove_prefix(static_cast<std::size_t>(end - shape.data()));
        array.shape.push_back(size);
        count *= static_cast<double>(size);
    }
    const std::string_view type = entry_of(words, "'descr'");
    if (entry_of(words, "'fortran_order'") != "False" && array.shape.size() > 1)
        fail("lies column by column; save a copy made by numpy.ascontiguousarray()");
    array.numbers = numbers_of(type, body);
    if (array.numbers.empty() && count != 0.0)
        fail(fmt::format("is of the kind {}; floats and integers are read", type));
    if (static_cast<double>(array.numbers.size()) != count) fail("is cut short");
    return array;
}

}  // namespace

NpzReader::NpzReader(fs::path path) : path_(std::move(path)), zip_(::unzOpen64(path_.c_str())) {
    if (zip_ == nullptr) FilePlace{path_}.fail("is no .npz (a zip of arrays)");
}

NpzReader::~NpzReader() {
    if (zip_ != nullptr) ::unzClose(zip_);
}

bool NpzReader::has(const std::string& name) const {
    return ::unzLocateFile(zip_, (name + ".npy").c_str(), 1) == UNZ_OK;
}

NumberArray NpzReader::read(const std::string& name) const {
    const FilePlace place{path_};
    const auto damaged = [&] { place.fail(fmt::format("its array {} is missing or damaged", name)); };
    unz_file_info64 info{};
    if (!has(name) || ::unzGetCurrentFileInfo64(zip_, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK ||
        ::unzOpenCurrentFile(zip_) != UNZ_OK)
        damaged();
    if (info.uncompressed_size > available_memory() / 4)  // it is there as bytes, as doubles and as points
        place.fail(fmt::format("its array {} takes {}; {} of memory are free", name,
                               memory_text(static_cast<double>(info.uncompressed_size)),
                               memory_text(static_cast<double>(available_memory()))));
    std::string bytes, block(std::size_t{1} << 20, '\0');
    int got = 0;
    while ((got = ::unzReadCurrentFile(zip_, block.data(), static_cast<unsigned>(block.size()))) > 0 &&
           bytes.size() <= info.uncompressed_size)
        bytes.append(block, 0, static_cast<std::size_t>(got));
    const int end = ::unzCloseCurrentFile(zip_);
    if (got != 0 || end != UNZ_OK) damaged();
    return array_of(bytes, name, place);
}

}  // namespace cloth::pipeline
