#include "pipeline/formats/obj.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <vector>

#include "pipeline/formats/mesh_text.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

/// The place in a list, counted from 0, that an index means: it counts from 1, a negative one back from the
/// latest of the `count` so far.
std::int64_t obj_index(std::string_view digits, std::string_view word, std::size_t count, const char* what,
                       const FilePlace& place) {
    const std::int64_t index = parse_integer(digits, place);
    if (index == 0) place.fail(quoted(word) + " has the index 0; an OBJ counts from 1");
    if (index > 0) return index - 1;
    const std::int64_t counted = static_cast<std::int64_t>(count) + index;
    if (counted < 0)
        place.fail(fmt::format("{} counts back further than the {} {} so far", quoted(word), count, what));
    return counted;
}

/// A face's corner: v, v/vt, v//vn or v/vt/vn.
struct ObjCorner {
    std::int64_t vertex = 0, uv = -1;  ///< counted from 0; -1: none
};
ObjCorner obj_corner(std::string_view word, std::size_t vertices, std::size_t uvs, const FilePlace& place) {
    ObjCorner corner;
    std::string_view rest = word;
    for (int part = 0;; ++part) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        const std::string_view digits = rest.substr(0, end);
        if (part > 2 || (digits.empty() && part != 1)) place.fail(quoted(word) + " is no corner of a face");
        if (part == 0) corner.vertex = obj_index(digits, word, vertices, "vertices", place);
        if (part == 1 && !digits.empty())
            corner.uv = obj_index(digits, word, uvs, "texture coordinates", place);
        if (part == 2 && parse_integer(digits, place) == 0)
            place.fail(quoted(word) + " has the index 0; an OBJ counts from 1");
        if (end == rest.size()) break;
        rest.remove_prefix(end + 1);
    }
    return corner;
}

/// Texture coordinates of all corners, once all are read.
std::vector<std::array<double, 2>> corner_uvs(const std::vector<std::int64_t>& of_corners,
                                              const std::vector<std::array<double, 2>>& uvs,
                                              const FilePlace& place) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    std::vector<std::array<double, 2>> all;
    for (const std::int64_t i : of_corners) {
        if (i >= static_cast<std::int64_t>(uvs.size()))
            place.fail(fmt::format("a face refers to texture coordinate {} (counted from 1); there are {}",
                                   i + 1, uvs.size()));
        all.push_back(i < 0 ? std::array<double, 2>{none, none} : uvs[static_cast<std::size_t>(i)]);
    }
    return all;
}

}  // namespace

MeshDraft read_obj(std::string_view text, const fs::path& path) {
    // What these lines say does not change the shape.
    constexpr std::array<std::string_view, 18> ignored{
        "vn",  "vp",    "s",        "mg",       "mtllib",     "usemap",    "maplib", "p",     "l",
        "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech",  "stech", "call"};
    std::vector<std::array<double, 2>> uvs;
    std::vector<std::int64_t> uv_of_corners;
    // Names that the faces to come have: of an object, of groups, of a material.
    std::array<std::vector<std::string>, 3> names;
    MeshDraft draft;
    FilePlace place{path};
    std::vector<std::string_view> words;
    std::vector<std::int64_t> corners;
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
        split_at_blanks(line.substr(0, line.find('#')), words);
        if (words.empty()) continue;
        if (words[0] == "v") {
            // x y z, then a weight or a colour, or both.
            if (words.size() < 4 || words.size() == 6 || words.size() > 8) {
                place.fail(fmt::format("a vertex of {} numbers; it has 3: x y z", words.size() - 1));
            }
            std::array<double, 7> numbers{};
            for (std::size_t i = 1; i < words.size(); ++i) numbers[i - 1] = parse_double(words[i], place);
            if (words.size() == 5 && numbers[3] != 1.0) place.fail("a vertex with a weight other than 1");
            draft.positions.push_back({numbers[0], numbers[1], numbers[2]});
        } else if (words[0] == "f") {
            corners.clear();
            for (std::size_t i = 1; i < words.size(); ++i) {
                const ObjCorner corner = obj_corner(words[i], draft.positions.size(), uvs.size(), place);
                corners.push_back(corner.vertex);
                uv_of_corners.push_back(corner.uv);
            }
            for (const auto& kind : names) {
                for (const std::string& name : kind) {
                    auto& faces = draft.parts[name];
                    if (faces.empty() || faces.back() != draft.face_count())
                        faces.push_back(draft.face_count());
                }
            }
            draft.add_face(corners);
            draft.lines.push_back(place.line);
        } else if (words[0] == "vt") {
            if (words.size() < 2) place.fail("a texture coordinate without numbers; it has 2: u v");
            uvs.push_back(
                {parse_double(words[1], place), words.size() > 2 ? parse_double(words[2], place) : 0.0});
        } else if (words[0] == "o" || words[0] == "g" || words[0] == "usemtl") {
            names[words[0] == "o" ? 0 : words[0] == "g" ? 1 : 2].assign(words.begin() + 1, words.end());
        } else if (std::find(ignored.begin(), ignored.end(), words[0]) == ignored.end()) {
            place.fail(quoted(words[0]) + " begins no line of an OBJ mesh");
        }
    }
    place.line = 0;
    if (!uvs.empty()) draft.uv = corner_uvs(uv_of_corners, uvs, place);
    return draft;
}

namespace {

/// Lines of texture coordinates, one for each that differs, and where each corner's is, counted from 1;
/// 0: it has none.
std::vector<int> put_corner_uvs(const TexturePoints& uv, fmt::memory_buffer& text) {
    std::map<std::array<double, 2>, int> seen;
    std::vector<int> at;
    for (Eigen::Index i = 0; i < uv.rows(); ++i) {
        if (!uv.row(i).allFinite()) {
            at.push_back(0);
            continue;
        }
        const auto [where, first] =
            seen.emplace(std::array<double, 2>{uv(i, 0), uv(i, 1)}, static_cast<int>(seen.size()) + 1);
        if (first) fmt::format_to(std::back_inserter(text), FMT_COMPILE("vt {} {}\n"), uv(i, 0), uv(i, 1));
        at.push_back(where->second);
    }
    return at;
}

}  // namespace

std::string obj_text(const MeshData& mesh) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v)
        fmt::format_to(out, FMT_COMPILE("v {} {} {}\n"), mesh.positions(v, 0), mesh.positions(v, 1),
                       mesh.positions(v, 2));
    const std::vector<int> uv = put_corner_uvs(mesh.uv, text);
    std::vector<std::string> groups(static_cast<std::size_t>(mesh.triangles.rows()));
    for (const MeshPart& part : mesh.parts)
        for (const int t : part.triangles) groups[static_cast<std::size_t>(t)] += ' ' + part.name;
    std::string group;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        if (const std::string& own = groups[static_cast<std::size_t>(t)]; own != group) {
            group = own;
            fmt::format_to(out, "g{}\n", group);
        }
        text.push_back('f');
        for (int k = 0; k < 3; ++k) {
            fmt::format_to(out, FMT_COMPILE(" {}"), mesh.triangles(t, k) + 1);
            const auto corner = static_cast<std::size_t>(3 * t + k);
            if (!uv.empty() && uv[corner] > 0) fmt::format_to(out, FMT_COMPILE("/{}"), uv[corner]);
        }
        text.push_back('\n');
    }
    return fmt::to_string(text);
}

namespace {

void put_object(const MeshOut& mesh, const MeshOut::Object& object, fmt::memory_buffer& text) {
    const auto out = std::back_inserter(text);
    // Lines like "v 0.1 0.2 0.3", of the object's vertices.
    const auto rows = [&](std::string_view word, const auto& values, auto number) {
        for (Eigen::Index v = object.first_vertex; v < object.first_vertex + object.vertex_count; ++v) {
            text.append(word);
            for (Eigen::Index k = 0; k < values.cols(); ++k)
                fmt::format_to(out, FMT_COMPILE(" {}"), number(values(v, k)));
            text.push_back('\n');
        }
    };
    const auto whole = [](double x) { return x; };
    const auto short_one = [](double x) { return static_cast<float>(x); };
    const bool uv = mesh.uv.rows() > 0, normals = mesh.normals.rows() > 0;
    if (!object.name.empty()) fmt::format_to(out, "o {}\n", object.name);
    rows("v", mesh.positions, whole);
    if (uv) rows("vt", mesh.uv, short_one);
    if (normals) rows("vn", mesh.normals, short_one);
    for (Eigen::Index t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
        text.push_back('f');
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles(t, k) + 1;
            if (uv && normals) {
                fmt::format_to(out, FMT_COMPILE(" {}/{}/{}"), v, v, v);
            } else if (uv) {
                fmt::format_to(out, " {}/{}", v, v);
            } else if (normals) {
                fmt::format_to(out, " {}//{}", v, v);
            } else {
                fmt::format_to(out, FMT_COMPILE(" {}"), v);
            }
        }
        text.push_back('\n');
    }
}

}  // namespace

std::string obj_text(const MeshOut& mesh) {
    fmt::memory_buffer text;
    if (mesh.objects.empty())
        put_object(mesh, {"", 0, mesh.positions.rows(), 0, mesh.triangles.rows()}, text);
    for (const MeshOut::Object& object : mesh.objects) put_object(mesh, object, text);
    return fmt::to_string(text);
}

}  // namespace cloth::pipeline
