#include "pipeline/formats/obj.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "pipeline/formats/mesh_text.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

/// A face's corner: v, v/vt, v//vn or v/vt/vn. Returns the vertex, counted from 0; negative numbers in the
/// file count back from the latest vertex.
std::int64_t obj_corner(std::string_view word, std::size_t vertices, const FilePlace& place) {
    std::int64_t vertex = 0;
    std::string_view rest = word;
    for (int part = 0;; ++part) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        const std::string_view digits = rest.substr(0, end);
        if (part > 2 || (digits.empty() && part != 1)) place.fail(quoted(word) + " is no corner of a face");
        const std::int64_t index = digits.empty() ? 1 : parse_integer(digits, place);
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

}  // namespace

MeshDraft read_obj(std::string_view text, const fs::path& path) {
    // What these lines say does not change the shape.
    constexpr std::array<std::string_view, 22> ignored{
        "vt",       "vn",         "vp",        "g",     "o",     "s",   "mg",    "usemtl",
        "mtllib",   "usemap",     "maplib",    "p",     "l",     "lod", "bevel", "c_interp",
        "d_interp", "shadow_obj", "trace_obj", "ctech", "stech", "call"};
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
            for (std::size_t i = 1; i < words.size(); ++i)
                corners.push_back(obj_corner(words[i], draft.positions.size(), place));
            draft.add_face(corners);
            draft.lines.push_back(place.line);
        } else if (std::find(ignored.begin(), ignored.end(), words[0]) == ignored.end()) {
            place.fail(quoted(words[0]) + " begins no line of an OBJ mesh");
        }
    }
    return draft;
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
