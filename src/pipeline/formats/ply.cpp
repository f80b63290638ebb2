#include "pipeline/formats/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "pipeline/formats/mesh_text.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

enum class Number { i8, u8, i16, u16, i32, u32, f32, f64 };

struct PlyProperty {
    std::string name;
    std::optional<Number> count;  ///< of a list: type of its length
    Number type{};
};

struct PlyElement {
    std::string name;
    std::size_t size = 0;
    std::vector<PlyProperty> properties;
};

enum class PlyFormat { ascii, little, big };

std::size_t bytes_of(Number type) {
    switch (type) {
        case Number::i8:
        case Number::u8:
            return 1;
        case Number::i16:
        case Number::u16:
            return 2;
        case Number::i32:
        case Number::u32:
        case Number::f32:
            return 4;
        default:
            return 8;
    }
}

bool is_float(Number type) {
    return type == Number::f32 || type == Number::f64;
}

Number ply_type(std::string_view name, const FilePlace& place) {
    static const std::map<std::string, Number, std::less<>> types{
        {"char", Number::i8},   {"int8", Number::i8},     {"uchar", Number::u8},   {"uint8", Number::u8},
        {"short", Number::i16}, {"int16", Number::i16},   {"ushort", Number::u16}, {"uint16", Number::u16},
        {"int", Number::i32},   {"int32", Number::i32},   {"uint", Number::u32},   {"uint32", Number::u32},
        {"float", Number::f32}, {"float32", Number::f32}, {"double", Number::f64}, {"float64", Number::f64}};
    const auto found = types.find(name);
    if (found == types.end()) place.fail(quoted(name) + " is no type of a PLY property");
    return found->second;
}

/// The bytes behind a header, word by word or number by number.
class PlyBody {
  public:
    PlyBody(std::string_view bytes, PlyFormat format, const fs::path& path, std::size_t line)
        : rest_(bytes), format_(format), place_{path, format == PlyFormat::ascii ? line : 0} {}

    const FilePlace& place() const { return place_; }
    std::size_t size_left() const { return rest_.size(); }

    /// In ASCII every entry of an element has a line.
    void begin_entry(const PlyElement& element, std::size_t index) {
        if (format_ != PlyFormat::ascii) return;
        do {
            if (rest_.empty()) end_reached(element, index);
            const std::size_t end = std::min(rest_.find('\n'), rest_.size());
            split_at_blanks(rest_.substr(0, end), words_);
            rest_.remove_prefix(std::min(end + 1, rest_.size()));
            ++place_.line;
        } while (words_.empty());
        word_ = 0;
    }
    void end_entry() const {
        if (format_ == PlyFormat::ascii && word_ != words_.size()) {
            place_.fail(fmt::format("{} numbers where the header promises {}", words_.size(), word_));
        }
    }

    double number(Number type, const PlyElement& element, std::size_t index) {
        if (format_ == PlyFormat::ascii) return parse_double(next_word(), place_);
        switch (type) {
            case Number::i8:
                return raw<std::int8_t>(element, index);
            case Number::u8:
                return raw<std::uint8_t>(element, index);
            case Number::i16:
                return raw<std::int16_t>(element, index);
            case Number::u16:
                return raw<std::uint16_t>(element, index);
            case Number::i32:
                return raw<std::int32_t>(element, index);
            case Number::u32:
                return raw<std::uint32_t>(element, index);
            case Number::f32:
                return raw<float>(element, index);
            default:
                return raw<double>(element, index);
        }
    }
    /// Lengths of lists and indices.
    std::int64_t integer(Number type, const PlyElement& element, std::size_t index) {
        if (format_ == PlyFormat::ascii) return parse_integer(next_word(), place_);
        return static_cast<std::int64_t>(number(type, element, index));  // exact: at most 32 bits
    }
    void require_end() const {
        const std::size_t more = rest_.find_first_not_of(" \t\r\n");
        if (more != std::string_view::npos) place_.fail("more follows than the header promises");
    }

  private:
    [[noreturn]] void end_reached(const PlyElement& element, std::size_t index) const {
        place_.fail(fmt::format("ends at {} {} of {} (counted from 0): cut short", element.name, index,
                                element.size));
    }
    std::string_view next_word() {
        if (word_ == words_.size()) {
            place_.fail(fmt::format("{} numbers, fewer than the header promises", words_.size()));
        }
        return words_[word_++];
    }
    template <class T>
    T raw(const PlyElement& element, std::size_t index) {
        if (rest_.size() < sizeof(T)) end_reached(element, index);
        std::array<char, sizeof(T)> bytes{};
        std::memcpy(bytes.data(), rest_.data(), sizeof(T));
        rest_.remove_prefix(sizeof(T));
        const bool file_is_little = format_ == PlyFormat::little;
        if (file_is_little != (std::endian::native == std::endian::little))
            std::reverse(bytes.begin(), bytes.end());
        return std::bit_cast<T>(bytes);
    }

    std::string_view rest_;
    PlyFormat format_;
    FilePlace place_;
    std::vector<std::string_view> words_;
    std::size_t word_ = 0;
};

struct PlyHeader {
    std::optional<PlyFormat> format;
    std::vector<PlyElement> elements;
};

/// Takes the header from the front of `text`; `place` ends at its last line.
PlyHeader take_header(std::string_view& text, FilePlace& place) {
    std::vector<std::string_view> words;
    const auto next_line = [&] {
        if (text.empty()) place.fail("the header has no end_header: cut short");
        const std::size_t end = std::min(text.find('\n'), text.size());
        split_at_blanks(text.substr(0, end), words);
        text.remove_prefix(std::min(end + 1, text.size()));
        ++place.line;
    };
    next_line();
    if (words.size() != 1 || words[0] != "ply") place.fail("is no PLY mesh: its first line is not \"ply\"");
    PlyHeader header;
    std::vector<PlyElement>& elements = header.elements;
    for (next_line(); words.empty() || words[0] != "end_header"; next_line()) {
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "format" && words.size() == 3) {
            if (words[1] == "ascii") header.format = PlyFormat::ascii;
            if (words[1] == "binary_little_endian") header.format = PlyFormat::little;
            if (words[1] == "binary_big_endian") header.format = PlyFormat::big;
            if (!header.format || words[2] != "1.0")
                place.fail(quoted(words[1]) + " is no format of PLY 1.0");
        } else if (words[0] == "element" && words.size() == 3) {
            const std::int64_t size = parse_integer(words[2], place);
            if (size < 0) place.fail("a negative number of " + std::string(words[1]));
            elements.push_back({std::string(words[1]), static_cast<std::size_t>(size), {}});
        } else if (words[0] == "property" && !elements.empty() && words.size() == 3) {
            elements.back().properties.push_back(
                {std::string(words[2]), std::nullopt, ply_type(words[1], place)});
        } else if (words[0] == "property" && !elements.empty() && words.size() == 5 && words[1] == "list") {
            const Number count = ply_type(words[2], place);
            if (is_float(count)) place.fail("a list's length is no whole number");
            elements.back().properties.push_back({std::string(words[4]), count, ply_type(words[3], place)});
        } else {
            place.fail(quoted(words[0]) + " begins no line of a PLY header, or has other words behind it");
        }
    }
    if (!header.format) place.fail("the header has no format");
    return header;
}

bool names_corners(const PlyProperty& p) {
    return p.name == "vertex_indices" || p.name == "vertex_index";
}

/// That an element can hold what it is read for, and that the file can hold it.
void check_element(const PlyElement& element, PlyFormat format, const PlyBody& body, const FilePlace& place) {
    std::size_t least = 0;  // bytes of one entry
    std::array<bool, 3> axes{};
    bool corners_named = false;
    for (const PlyProperty& p : element.properties) {
        least += format == PlyFormat::ascii ? 2 : bytes_of(p.count.value_or(p.type));
        for (std::size_t k = 0; k < 3; ++k) axes[k] = axes[k] || p.name == std::string(1, "xyz"[k]);
        corners_named = corners_named || (names_corners(p) && p.count && !is_float(p.type));
    }
    if (element.name == "vertex" && !(axes[0] && axes[1] && axes[2]))
        place.fail("the vertices lack one of x, y, z");
    if (element.name == "face" && element.size > 0 && !corners_named)
        place.fail("the faces have no list vertex_indices");
    // A wrong size must not ask for memory that the file cannot fill.
    if (element.size > 0 && (least == 0 || element.size > body.size_left() / least + 1)) {
        place.fail(fmt::format("promises {} of {}, more than the file holds: cut short", element.size,
                               element.name));
    }
}

/// Entry `i` of an element: a vertex, a face, or what is passed over.
void read_entry(const PlyElement& element, std::size_t i, PlyBody& body, MeshDraft& draft) {
    const bool vertices = element.name == "vertex", faces = element.name == "face";
    body.begin_entry(element, i);
    std::array<double, 3> position{};
    std::vector<std::int64_t> face;
    for (const PlyProperty& p : element.properties) {
        if (!p.count) {
            const double value = body.number(p.type, element, i);
            if (!vertices) continue;
            const std::size_t axis = std::string_view("xyz").find(p.name);
            if (p.name.size() != 1 || axis == std::string_view::npos) continue;
            if (!std::isfinite(value))
                body.place().fail(
                    fmt::format("{} of vertex {} (counted from 0) is not a finite number", p.name, i));
            position[axis] = value;
            continue;
        }
        const std::int64_t length = body.integer(*p.count, element, i);
        const bool corners = faces && names_corners(p);
        if (length < 0) body.place().fail("a list of negative length");
        face.clear();
        for (std::int64_t k = 0; k < length; ++k) {
            if (corners) {
                face.push_back(body.integer(p.type, element, i));
            } else {
                body.number(p.type, element, i);
            }
        }
        if (!corners) continue;
        draft.add_face(face);
        draft.lines.push_back(body.place().line);
    }
    body.end_entry();
    if (vertices) draft.positions.push_back(position);
}

}  // namespace

MeshDraft read_ply(std::string_view bytes, const fs::path& path) {
    FilePlace place{path};
    const PlyHeader header = take_header(bytes, place);
    MeshDraft draft;
    PlyBody body(bytes, *header.format, path, place.line);
    for (const PlyElement& element : header.elements) {
        check_element(element, *header.format, body, place);
        for (std::size_t i = 0; i < element.size; ++i) read_entry(element, i, body, draft);
    }
    body.require_end();
    return draft;
}

std::string ply_bytes(const MeshOut& mesh) {
    const bool normals = mesh.normals.rows() > 0, uv = mesh.uv.rows() > 0;
    std::string bytes = "ply\nformat binary_little_endian 1.0\n";
    for (std::size_t i = 0; i < mesh.objects.size(); ++i)
        bytes += fmt::format("comment object {} is {}\n", i, mesh.objects[i].name);
    bytes += fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
                         mesh.positions.rows());
    if (normals) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
    if (uv) bytes += "property float s\nproperty float t\n";
    bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", mesh.triangles.rows());
    if (!mesh.objects.empty()) bytes += "property int object\n";
    bytes += "end_header\n";
    bytes.reserve(bytes.size() +
                  static_cast<std::size_t>(44 * mesh.positions.rows() + 17 * mesh.triangles.rows()));
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
        for (int k = 0; k < 3; ++k) put(bytes, mesh.positions(v, k));
        for (int k = 0; normals && k < 3; ++k) put(bytes, static_cast<float>(mesh.normals(v, k)));
        for (int k = 0; uv && k < 2; ++k) put(bytes, static_cast<float>(mesh.uv(v, k)));
    }
    std::size_t object = 0;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        bytes.push_back(3);
        for (int k = 0; k < 3; ++k) put(bytes, mesh.triangles(t, k));
        if (mesh.objects.empty()) continue;
        while (t >= mesh.objects[object].first_triangle + mesh.objects[object].triangle_count) ++object;
        put(bytes, static_cast<int>(object));
    }
    return bytes;
}

}  // namespace cloth::pipeline
