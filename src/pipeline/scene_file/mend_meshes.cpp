// Meshes as modellers leave them, made into those of cloths, and what is told of it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "pipeline/scene_file/read_scene.h"
#include "pipeline/scene_file/tables.h"
#include "sim/scene/mesh.h"
#include "sim/scene/mesh_repair.h"

namespace cloth::pipeline {
namespace {

std::vector<std::string> told(const MeshRepair& repair, const ClothDesc& cloth) {
    std::vector<std::string> notes;
    const auto note = [&](int count, const char* one, const char* many, const std::string& text) {
        if (count > 0) notes.push_back(fmt::format("{} {} {}", count, count == 1 ? one : many, text));
    };
    const auto of_triangles = [&](int count, const std::string& text) {
        note(count, "triangle", "triangles", text);
    };
    const auto of_vertices = [&](int count, const std::string& text) {
        note(count, "vertex", "vertices", text);
    };
    note(repair.joined, "doubled vertex", "doubled vertices",
         "joined with what stands at the same place; weld = false leaves them apart");
    of_vertices(repair.doubled,
                "at the place of another left as weld = false wants it: the cloth is open there");
    of_triangles(repair.collapsed, "with a repeated corner left out");
    of_triangles(repair.repeated, "with the corners of another left out");
    of_vertices(repair.loose, "of no triangle left out");
    of_triangles(repair.turned,
                 fmt::format("of {} turned over, so that each piece faces the way that most of it does",
                             cloth.mesh->triangles.rows()));
    return notes;
}

/// Vertex numbers of a selection: from those of the file to those of the mended mesh, each once.
void renumber(Reader& reader, const std::string& key, VertexSelection& selection, const MeshRepair& repair) {
    std::vector<int> vertices;
    for (const int v : selection.vertices) {
        const auto count = static_cast<int>(repair.vertex_of.size());
        if (v < 0 || v >= count)
            reader.fail(
                key + ".vertices",
                fmt::format("vertex {} does not exist; the cloth's file has vertices 0 … {}", v, count - 1));
        const int now = repair.vertex_of[static_cast<std::size_t>(v)];
        if (now < 0)
            reader.fail(key + ".vertices", fmt::format("vertex {} belongs to no triangle of the cloth", v));
        if (std::find(vertices.begin(), vertices.end(), now) == vertices.end()) vertices.push_back(now);
    }
    selection.vertices = std::move(vertices);
}

/// Refuses a seam whose two sides have become one.
void check_seam(Reader& reader, const SeamDesc& seam, const std::string& key) {
    const auto& [first, second] = seam.sides;
    if (first.cloth != second.cloth || first.vertices.empty() ||
        first.vertices.size() != second.vertices.size())
        return;
    for (std::size_t i = 0; i < first.vertices.size(); ++i) {
        if (first.vertices[i] == second.vertices[seam.reverse ? first.vertices.size() - 1 - i : i])
            reader.fail(
                key,
                "sews vertices that stand at one place and are joined already: leave the seam out, or "
                "give the cloth weld = false");
    }
}

// ---------------------------------------------------------------- sizes

/// Refuses coordinates beyond those that a scene may give.
void check_reach(Reader& reader, const std::string& key, const Points& positions, double metres) {
    const double reach = metres * positions.cwiseAbs().maxCoeff();
    if (!(reach <= ranges::place.high))
        reader.fail(key, fmt::format("has a vertex at {:.3g} m; must be within {} m of the origin", reach,
                                     number_text(ranges::place.high)));
}

double extent(const Points& positions) {
    return (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).norm();
}

/// Of a body [m]; a plane has none.
double extent(const ColliderDesc& c) {
    switch (c.shape) {
        case Shape::plane:
            return 0.0;
        case Shape::sphere:
            return 2.0 * c.radius;
        case Shape::box:
            return c.size.norm();
        case Shape::mesh:
            return c.scale * length_of(c.units) * extent(c.mesh->positions);
        default:
            return c.height + 2.0 * c.radius;
    }
}

/// A sewing pattern's rest shape and seams, as keys of the scene.
void sew_patterns(Reader& reader, Scene& scene) {
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
        ClothDesc& cloth = scene.cloths[c];
        if (!cloth.mesh || !cloth.mesh->pattern) continue;
        if (!reader.find(entry("cloth", c) + ".rest")) cloth.rest = RestShape::uv;
        if (cloth.rest == RestShape::uv && !cloth.uv_scale) cloth.uv_scale = 1.0;
        for (auto& rows : cloth.mesh->stitches) {
            if (rows[0].empty()) continue;
            SeamDesc& seam = scene.seams.emplace_back();
            for (std::size_t side = 0; side < 2; ++side) {
                seam.sides[side].cloth = static_cast<int>(c);
                seam.sides[side].vertices = std::move(rows[side]);
            }
        }
        cloth.mesh->pattern = false;
        cloth.mesh->stitches.clear();
    }
}

}  // namespace

void mend_meshes(Reader& reader, SceneFile& file) {
    Scene& scene = file.scene;
    file.vertices_in_file.assign(scene.cloths.size(), {});
    std::vector<MeshRepair> repairs(scene.cloths.size());
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        const ColliderDesc& collider = scene.colliders[c];
        const double metres = length_of(collider.units);
        if (collider.cache)
            for (const Points& frame : collider.cache->frames)
                check_reach(reader, entry("collider", c) + ".cache", frame, metres);
        if (collider.mesh)
            check_reach(reader, entry("collider", c) + ".mesh", collider.mesh->positions, metres);
    }
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
        ClothDesc& cloth = scene.cloths[c];
        const std::string key = entry("cloth", c);
        if (cloth.mesh) check_reach(reader, key + ".mesh", cloth.mesh->positions, length_of(cloth.units));
        if (cloth.pose) check_reach(reader, key + ".pose", *cloth.pose, length_of(cloth.units));
        if (!cloth.mesh) continue;
        if (cloth.pose && cloth.pose->rows() != cloth.mesh->positions.rows())
            reader.fail(key + ".pose", fmt::format("has {} vertices; the rest shape has {}",
                                                   cloth.pose->rows(), cloth.mesh->positions.rows()));
        MeshRepair& repair = repairs[c];
        repair = repair_cloth_mesh(*cloth.mesh, cloth.pose ? &*cloth.pose : nullptr, cloth.weld);
        if (repair.doubled > 0 && scene.simulation.contact == ContactKind::barrier)
            reader.fail(key + ".weld",
                        fmt::format("is false, and {} vertices stand at the place of another: contact = "
                                    "\"barrier\" cannot hold them apart; leave weld out to join them",
                                    repair.doubled));
        for (const std::string& note : told(repair, cloth))
            file.notes.push_back(fmt::format("{}.mesh: {}: {}", key, file.files[key + ".mesh"], note));
        if (repair.given.size() != repair.vertex_of.size()) {
            if (cloth.pose) cloth.pose = Points((*cloth.pose)(repair.given, Eigen::all));
            file.vertices_in_file[c] = repair.given;
        }
        cloth.mesh = repair.mesh;
    }
    for (std::size_t i = 0; i < scene.pins.size(); ++i) {
        PinDesc& pin = scene.pins[i];
        if (!file.vertices_in_file[static_cast<std::size_t>(pin.cloth)].empty())
            renumber(reader, entry("pin", i), pin, repairs[static_cast<std::size_t>(pin.cloth)]);
    }
    for (std::size_t i = 0; i < scene.seams.size(); ++i) {
        SeamDesc& seam = scene.seams[i];
        const std::string key = entry("seam", i);
        bool mended = false;
        for (std::size_t side = 0; side < 2; ++side) {
            const auto c = static_cast<std::size_t>(seam.sides[side].cloth);
            if (file.vertices_in_file[c].empty()) continue;
            mended = true;
            renumber(reader, key + (side == 0 ? ".first" : ".second"), seam.sides[side], repairs[c]);
        }
        if (mended) check_seam(reader, seam, key);
    }
    file.own_seams = scene.seams.size();
    sew_patterns(reader, scene);
}

void note_sizes(SceneFile& file) {
    struct Body {
        std::string key, from_file;  ///< the key that names its file, if it is from one
        LengthUnit units;
        double extent;  ///< [m]
    };
    if (file.files.empty()) return;
    std::vector<Body> bodies;
    for (std::size_t c = 0; c < file.scene.cloths.size(); ++c) {
        const ClothDesc& cloth = file.scene.cloths[c];
        const std::string key = entry("cloth", c);
        bodies.push_back({key,
                          cloth.mesh   ? key + ".mesh"
                          : cloth.pose ? key + ".pose"
                                       : "",
                          cloth.units, extent(start_positions(cloth, rest_shape(cloth)))});
    }
    for (std::size_t c = 0; c < file.scene.colliders.size(); ++c) {
        const ColliderDesc& collider = file.scene.colliders[c];
        const std::string key = entry("collider", c);
        if (collider.shape == Shape::plane) continue;
        bodies.push_back(
            {key, collider.shape == Shape::mesh ? key + ".mesh" : "", collider.units, extent(collider)});
    }
    constexpr double odd_ratio = 30.0, odd_size = 30.0, odd_smallness = 5e-3;  // [m]
    for (const Body& body : bodies) {
        if (body.from_file.empty()) continue;
        double least = std::numeric_limits<double>::infinity(), most = 0.0;
        for (const Body& other : bodies) {
            if (&other == &body) continue;
            least = std::min(least, other.extent);
            most = std::max(most, other.extent);
        }
        std::string odd;
        if (most > 0.0 && body.extent > odd_ratio * most)
            odd = fmt::format(", {:.3g} times the largest thing that it can meet", body.extent / most);
        if (most > 0.0 && body.extent < least / odd_ratio)
            odd = fmt::format(", the smallest thing that it can meet is {:.3g} times as large",
                              least / body.extent);
        if (odd.empty() && body.extent < odd_size && body.extent > odd_smallness) continue;
        file.notes.push_back(fmt::format(
            "{}: is {:.3g} m across{}; is {} the unit of its file? units names it: one of {}", body.from_file,
            body.extent, odd, Value<LengthUnit>::write(body.units), join(Value<LengthUnit>::known())));
        return;  // the others are odd because this one is
    }
}

}  // namespace cloth::pipeline
