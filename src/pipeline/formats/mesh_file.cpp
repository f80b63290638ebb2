// OBJ and PLY are read here and everything else by assimp. assimp keeps floats, splits an OBJ's vertices
// wherever corners differ in normal or texture coordinate, and numbers them by first use; a cloth needs the
// file's own vertices, in their order, to the last digit: pins name them, and states are compared vertex by
// vertex.

#include "pipeline/formats/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

/// Where in a file something is wrong; line 0: no line can be named.
struct Place {
    const fs::path& path;
    std::size_t line = 0;

    [[noreturn]] void fail(const std::string& message) const {
        std::string text = path.string() + (line ? fmt::format(":{}", line) : "") + ": " + message;
        for (char& c : text) {
            if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
        }
        throw Error(ExitCode::invalid_scene, text);
    }
};

constexpr const char* triangulate = "a cloth has triangles only: triangulate the mesh first";

// ---------------------------------------------------------------- words of a text file

/// A word in a message, cut short where it is long.
std::string quoted(std::string_view word) {
    return word.size() <= 40 ? fmt::format("\"{}\"", word) : fmt::format("\"{}…\"", word.substr(0, 40));
}

/// Splits at blanks.
void split(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    constexpr std::string_view blanks = " \t\r\v\f";
    while (true) {
        const std::size_t begin = line.find_first_not_of(blanks);
        if (begin == std::string_view::npos) return;
        line.remove_prefix(begin);
        const std::size_t end = std::min(line.find_first_of(blanks), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

double read_double(std::string_view word, const Place& place) {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (problem == std::errc::result_out_of_range) place.fail(quoted(word) + " does not fit a double");
    if (problem != std::errc() || end != digits.data() + digits.size())
        place.fail(quoted(word) + " is no number");
    if (!std::isfinite(value)) place.fail(quoted(word) + " is not a finite number");
    return value;
}

std::int64_t read_integer(std::string_view word, const Place& place) {
    std::int64_t value = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (problem == std::errc::result_out_of_range) place.fail(quoted(word) + " is too large");
    if (problem != std::errc() || end != word.data() + word.size())
        place.fail(quoted(word) + " is no whole number");
    return value;
}

// ---------------------------------------------------------------- what a file held

/// A mesh as it is read; indices are checked once all vertices are known.
struct Draft {
    std::vector<std::array<double, 3>> positions;
    std::vector<std::array<std::int64_t, 3>> triangles;  ///< counted from 0
    std::vector<std::size_t> lines;                      ///< of each triangle; empty where there are none
};

MeshData finish(const Draft& draft, const fs::path& path, bool faces_wanted) {
    const std::size_t n = draft.positions.size(), m = draft.triangles.size();
    const Place whole{path};
    if (n == 0) whole.fail("has no vertices");
    if (faces_wanted && m == 0) whole.fail("has no faces");
    if (std::max(n, m) > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        whole.fail("is too large");
    MeshData mesh;
    mesh.positions.resize(static_cast<Eigen::Index>(n), 3);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            mesh.positions(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                draft.positions[i][k];
        }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(m), 3);
    for (std::size_t t = 0; t < m; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t v = draft.triangles[t][k];
            if (v < 0 || v >= static_cast<std::int64_t>(n)) {
                const Place place{path, draft.lines.empty() ? 0 : draft.lines[t]};
                place.fail(
                    fmt::format("face {} refers to vertex {}; there are {}, both counted from 0", t, v, n));
            }
            mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = static_cast<int>(v);
        }
    }
    return mesh;
}

// ---------------------------------------------------------------- OBJ

/// A face's corner: v, v/vt, v//vn or v/vt/vn. Returns the vertex, counted from 0; negative numbers in the
/// file count back from the latest vertex.
std::int64_t obj_corner(std::string_view word, std::size_t vertices, const Place& place) {
    std::int64_t vertex = 0;
    std::string_view rest = word;
    for (int part = 0;; ++part) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        const std::string_view digits = rest.substr(0, end);
        if (part > 2 || (digits.empty() && part != 1)) place.fail(quoted(word) + " is no corner of a face");
        const std::int64_t index = digits.empty() ? 1 : read_integer(digits, place);
        if (index == 0) place.fail(quoted(word) + " has the index 0; an OBJ counts from 1");
        if (part == 0) vertex = index;
        if (end == rest.size()) break;
        rest.remove_prefix(end + 1);
    }
    if (vertex > 0) return vertex - 1;
    const std::int64_t counted = static_cast<std::int64_t>(vertices) + vertex;
    if (counted < 0) {
        place.fail(fmt::format("{} counts back further than the {} vertices so far", quoted(word), vertices));
    }
    return counted;
}

Draft read_obj(std::string_view text, const fs::path& path) {
    // What these lines say does not change the shape.
    constexpr std::array<std::string_view, 22> ignored{
        "vt",       "vn",         "vp",        "g",     "o",     "s",   "mg",    "usemtl",
        "mtllib",   "usemap",     "maplib",    "p",     "l",     "lod", "bevel", "c_interp",
        "d_interp", "shadow_obj", "trace_obj", "ctech", "stech", "call"};
    Draft draft;
    Place place{path};
    std::vector<std::string_view> words;
    std::string joined;
    std::size_t next_line = 1;
    while (!text.empty()) {
        place.line = next_line;
        joined.clear();
        std::string_view line;
        // A backslash at the end joins the next line.
        for (bool more = true; more;) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            line = text.substr(0, end);
            text.remove_prefix(std::min(end + 1, text.size()));
            ++next_line;
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            more = !line.empty() && line.back() == '\\' && !text.empty();
            if (more || !joined.empty()) {
                joined += line.substr(0, line.size() - (more ? 1 : 0));
                joined += ' ';
                line = joined;
            }
        }
        split(line.substr(0, line.find('#')), words);
        if (words.empty()) continue;
        if (words[0] == "v") {
            // x y z, then a weight or a colour, or both.
            if (words.size() < 4 || words.size() == 6 || words.size() > 8) {
                place.fail(fmt::format("a vertex of {} numbers; it has 3: x y z", words.size() - 1));
            }
            std::array<double, 7> numbers{};
            for (std::size_t i = 1; i < words.size(); ++i) numbers[i - 1] = read_double(words[i], place);
            if (words.size() == 5 && numbers[3] != 1.0) place.fail("a vertex with a weight other than 1");
            draft.positions.push_back({numbers[0], numbers[1], numbers[2]});
        } else if (words[0] == "f") {
            if (words.size() != 4) {
                place.fail(fmt::format("face {} (counted from 0) has {} corners; {}", draft.triangles.size(),
                                       words.size() - 1, triangulate));
            }
            std::array<std::int64_t, 3> corners{};
            for (std::size_t i = 0; i < 3; ++i)
                corners[i] = obj_corner(words[i + 1], draft.positions.size(), place);
            draft.triangles.push_back(corners);
            draft.lines.push_back(place.line);
        } else if (std::find(ignored.begin(), ignored.end(), words[0]) == ignored.end()) {
            place.fail(quoted(words[0]) + " begins no line of an OBJ mesh");
        }
    }
    return draft;
}

// ---------------------------------------------------------------- PLY

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

Number ply_type(std::string_view name, const Place& place) {
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

    const Place& place() const { return place_; }
    std::size_t size_left() const { return rest_.size(); }

    /// In ASCII every entry of an element has a line.
    void begin_entry(const PlyElement& element, std::size_t index) {
        if (format_ != PlyFormat::ascii) return;
        do {
            if (rest_.empty()) end_reached(element, index);
            const std::size_t end = std::min(rest_.find('\n'), rest_.size());
            split(rest_.substr(0, end), words_);
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
        if (format_ == PlyFormat::ascii) return read_double(next_word(), place_);
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
        if (format_ == PlyFormat::ascii) return read_integer(next_word(), place_);
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
    Place place_;
    std::vector<std::string_view> words_;
    std::size_t word_ = 0;
};

Draft read_ply(std::string_view text, const fs::path& path) {
    Place place{path};
    std::vector<std::string_view> words;
    const auto next_line = [&] {
        if (text.empty()) place.fail("the header has no end_header: cut short");
        const std::size_t end = std::min(text.find('\n'), text.size());
        split(text.substr(0, end), words);
        text.remove_prefix(std::min(end + 1, text.size()));
        ++place.line;
    };
    next_line();
    if (words.size() != 1 || words[0] != "ply") place.fail("is no PLY mesh: its first line is not \"ply\"");
    std::optional<PlyFormat> format;
    std::vector<PlyElement> elements;
    for (next_line(); words.empty() || words[0] != "end_header"; next_line()) {
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "format" && words.size() == 3) {
            if (words[1] == "ascii") format = PlyFormat::ascii;
            if (words[1] == "binary_little_endian") format = PlyFormat::little;
            if (words[1] == "binary_big_endian") format = PlyFormat::big;
            if (!format || words[2] != "1.0") place.fail(quoted(words[1]) + " is no format of PLY 1.0");
        } else if (words[0] == "element" && words.size() == 3) {
            const std::int64_t size = read_integer(words[2], place);
            if (size < 0) place.fail("a negative number of " + std::string(words[1]));
            elements.push_back({std::string(words[1]), static_cast<std::size_t>(size), {}});
        } else if (words[0] == "property" && !elements.empty() && words.size() == 3) {
            elements.back().properties.push_back(
                {std::string(words[2]), std::nullopt, ply_type(words[1], place)});
        } else if (words[0] == "property" && !elements.empty() && words.size() == 5 && words[1] == "list") {
            const Number count = ply_type(words[2], place);
            if (count == Number::f32 || count == Number::f64)
                place.fail("a list's length is no whole number");
            elements.back().properties.push_back({std::string(words[4]), count, ply_type(words[3], place)});
        } else {
            place.fail(quoted(words[0]) + " begins no line of a PLY header, or has other words behind it");
        }
    }
    if (!format) place.fail("the header has no format");

    Draft draft;
    PlyBody body(text, *format, path, place.line);
    for (const PlyElement& element : elements) {
        const bool vertices = element.name == "vertex", faces = element.name == "face";
        std::size_t least = 0;  // bytes of one entry
        std::array<bool, 3> axes{};
        bool corners_named = false;
        for (const PlyProperty& p : element.properties) {
            least += *format == PlyFormat::ascii ? 2 : bytes_of(p.count.value_or(p.type));
            for (std::size_t k = 0; k < 3; ++k) axes[k] = axes[k] || p.name == std::string(1, "xyz"[k]);
            const bool corners = p.name == "vertex_indices" || p.name == "vertex_index";
            corners_named =
                corners_named || (corners && p.count && p.type != Number::f32 && p.type != Number::f64);
        }
        if (vertices && !(axes[0] && axes[1] && axes[2])) place.fail("the vertices lack one of x, y, z");
        if (faces && element.size > 0 && !corners_named) place.fail("the faces have no list vertex_indices");
        // A wrong size must not ask for memory that the file cannot fill.
        if (element.size > 0 && (least == 0 || element.size > body.size_left() / least + 1)) {
            place.fail(fmt::format("promises {} of {}, more than the file holds: cut short", element.size,
                                   element.name));
        }
        for (std::size_t i = 0; i < element.size; ++i) {
            body.begin_entry(element, i);
            std::array<double, 3> position{};
            for (const PlyProperty& p : element.properties) {
                if (!p.count) {
                    const double value = body.number(p.type, element, i);
                    if (!vertices) continue;
                    const std::size_t axis = std::string_view("xyz").find(p.name);
                    if (p.name.size() != 1 || axis == std::string_view::npos) continue;
                    if (!std::isfinite(value))
                        body.place().fail(fmt::format(
                            "{} of vertex {} (counted from 0) is not a finite number", p.name, i));
                    position[axis] = value;
                    continue;
                }
                const std::int64_t length = body.integer(*p.count, element, i);
                const bool corners = faces && (p.name == "vertex_indices" || p.name == "vertex_index");
                if (corners && length != 3) {
                    body.place().fail(
                        fmt::format("face {} (counted from 0) has {} corners; {}", i, length, triangulate));
                }
                if (length < 0) body.place().fail("a list of negative length");
                std::array<std::int64_t, 3> triangle{};
                for (std::int64_t k = 0; k < length; ++k) {
                    if (corners) {
                        triangle[static_cast<std::size_t>(k)] = body.integer(p.type, element, i);
                    } else {
                        body.number(p.type, element, i);
                    }
                }
                if (!corners) continue;
                draft.triangles.push_back(triangle);
                draft.lines.push_back(body.place().line);
            }
            body.end_entry();
            if (vertices) draft.positions.push_back(position);
        }
    }
    body.require_end();
    return draft;
}

// ---------------------------------------------------------------- other formats

/// Appends the meshes of a node and of those below it, moved to where the nodes stand.
void append(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent, const Place& place,
            Draft& draft) {
    Eigen::Matrix4d local;
    for (unsigned r = 0; r < 4; ++r) {
        for (unsigned c = 0; c < 4; ++c) local(r, c) = node.mTransformation[r][c];
    }
    const Eigen::Matrix4d world = parent * local;
    const bool moved = !world.isIdentity(0.0);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
        const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
        const auto first = static_cast<std::int64_t>(draft.positions.size());
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D& p = mesh.mVertices[v];
            Eigen::Vector4d x(p.x, p.y, p.z, 1.0);
            if (moved) x = world * x;
            if (!x.allFinite()) {
                place.fail(fmt::format("vertex {} (counted from 0) is not finite", draft.positions.size()));
            }
            draft.positions.push_back({x(0), x(1), x(2)});
        }
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices != 3) {
                place.fail(fmt::format("face {} (counted from 0) has {} corners; {}", draft.triangles.size(),
                                       face.mNumIndices, triangulate));
            }
            draft.triangles.push_back(
                {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
        }
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) append(scene, *node.mChildren[i], world, place, draft);
}

/// An STL has no vertex list: equal coordinates are its only way to say that triangles share a corner.
void join_equal_positions(Draft& draft) {
    std::map<std::array<double, 3>, std::int64_t> seen;
    std::vector<std::int64_t> joined;
    std::vector<std::array<double, 3>> kept;
    for (const auto& p : draft.positions) {
        const auto [at, is_new] = seen.emplace(p, static_cast<std::int64_t>(kept.size()));
        if (is_new) kept.push_back(p);
        joined.push_back(at->second);
    }
    draft.positions = std::move(kept);
    for (auto& triangle : draft.triangles) {
        for (auto& v : triangle) v = joined[static_cast<std::size_t>(v)];
    }
}

Draft read_other(const fs::path& path, const std::string& extension) {
    const Place place{path};
    Assimp::Importer importer;
    if (!importer.IsExtensionSupported(extension)) {
        place.fail("\"" + extension +
                   "\" is no format of a mesh that can be read; OBJ, PLY, STL and glTF are some");
    }
    const aiScene* scene = importer.ReadFile(path.string(), 0);
    if (scene == nullptr || scene->mRootNode == nullptr) {
        place.fail(std::string("cannot be read as a mesh: ") + importer.GetErrorString());
    }
    Draft draft;
    append(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), place, draft);
    if (extension == ".stl") join_equal_positions(draft);
    return draft;
}

MeshData read_any(const fs::path& path, bool faces_wanted) {
    const Place place{path};
    std::error_code problem;
    if (fs::is_directory(path, problem)) place.fail("is a folder, not a mesh file");
    if (!fs::exists(path, problem)) place.fail("there is no such file");
    std::string text;
    try {
        text = read_file(path);
    } catch (const Error& e) {
        throw Error(ExitCode::invalid_scene, e.what());
    }
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) place.fail("is empty");
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (extension == ".obj") return finish(read_obj(text, path), path, faces_wanted);
    if (extension == ".ply") return finish(read_ply(text, path), path, faces_wanted);
    return finish(read_other(path, extension), path, faces_wanted);
}

}  // namespace

MeshData read_mesh(const fs::path& path) {
    return read_any(path, true);
}

Points read_points(const fs::path& path) {
    return read_any(path, false).positions;
}

void write_mesh(const MeshData& mesh, MeshFormat format, const fs::path& path) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    const bool obj = format == MeshFormat::obj;
    if (!obj) {
        fmt::format_to(
            out,
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
            "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            mesh.positions.rows(), mesh.triangles.rows());
    }
    for (Eigen::Index i = 0; i < mesh.positions.rows(); ++i) {
        fmt::format_to(out, "{}{:.17g} {:.17g} {:.17g}\n", obj ? "v " : "", mesh.positions(i, 0),
                       mesh.positions(i, 1), mesh.positions(i, 2));
    }
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const int base = obj ? 1 : 0;  // an OBJ counts from 1
        fmt::format_to(out, "{} {} {} {}\n", obj ? "f" : "3", mesh.triangles(t, 0) + base,
                       mesh.triangles(t, 1) + base, mesh.triangles(t, 2) + base);
    }
    write_file(path, {text.data(), text.size()});
}

}  // namespace cloth::pipeline
