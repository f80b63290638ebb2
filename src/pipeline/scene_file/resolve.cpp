#include <algorithm>
#include <set>

#include "base/memory.h"
#include "base/portable_math.h"
#include "pipeline/formats/error.h"
#include "pipeline/scene_file/memory_need.h"
#include "pipeline/scene_file/read_scene.h"
#include "pipeline/scene_file/tables.h"
#include "sim/model.h"
#include "sim/model/possible.h"
#include "sim/motion/mesh_cache.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"

namespace cloth::pipeline {
namespace {

template <class Desc>
void require_distinct_names(Reader& reader, const char* table, const std::vector<Desc>& descs) {
    std::set<std::string> names;
    for (std::size_t i = 0; i < descs.size(); ++i) {
        if (!names.insert(descs[i].name).second) {
            reader.fail(entry(table, i) + ".name",
                        fmt::format("\"{}\" is taken; names must differ", descs[i].name));
        }
    }
}

// ---------------------------------------------------------------- keys that stand in each other's way

void check_cloth_keys(Reader& reader, const std::string& cloth, const ClothLookDesc& look) {
    const auto given = [&](const char* key) { return reader.find(cloth + "." + key) != nullptr; };
    const auto refuse = [&](const char* key, const std::string& message) {
        reader.fail(cloth + "." + key, message);
    };
    const bool mesh = given("mesh"), disc = given("radius");
    for (const char* key : {"size", "resolution", "diagonals"}) {
        if ((mesh || disc) && given(key))
            refuse(key, fmt::format("belongs to a grid, but the cloth has a {}; give one of the two",
                                    mesh ? "mesh" : "radius"));
    }
    if (given("rings") && !disc) refuse("rings", "belongs to a disc; give its radius too");
    if (given("units") && !mesh && !given("pose"))
        refuse("units", "belongs to a mesh or pose; sizes in a scene are in metres");
    if (given("weld") && !mesh) refuse("weld", "belongs to a mesh; other shapes have no doubled vertices");
    if (given("edge_length") && !mesh)
        refuse("edge_length", "belongs to a sewing pattern; name its file with mesh");
    if (given("rest") && !mesh) refuse("rest", "belongs to a mesh; other shapes have no texture coordinates");
    if (mesh && disc) refuse("radius", "belongs to a disc, but the cloth has a mesh; give one of the two");
    if (given("texture") && given("pattern"))
        refuse("pattern", "stands beside texture, which takes its place; give one or the other");
    if (look.pattern_colors.empty() || look.pattern_colors.size() > 3)
        refuse("pattern_colors",
               fmt::format("has {} entries; must be one to three colours", look.pattern_colors.size()));
}

void check_selection_keys(Reader& reader, const std::string& table) {
    const toml::node* vertices = reader.find(table + ".vertices");
    if (vertices && vertices->as_array()->empty())
        reader.fail(table + ".vertices", "is empty; name at least one vertex");
}

void check_keys(Reader& reader, const SceneFile& file) {
    require_distinct_names(reader, "cloth", file.scene.cloths);
    require_distinct_names(reader, "collider", file.scene.colliders);
    for (std::size_t i = 0; i < file.scene.cloths.size(); ++i)
        check_cloth_keys(reader, entry("cloth", i), file.looks.cloths[i]);
    for (std::size_t i = 0; i < file.scene.colliders.size(); ++i) {
        const std::string collider = entry("collider", i);
        for (const char* name : {".mesh", ".cache", ".units"}) {
            if (reader.find(collider + name) && file.scene.colliders[i].shape != Shape::mesh)
                reader.fail(collider + name, "belongs to shape = \"mesh\"");
        }
        for (const char* name : {".cache_start", ".cache_speed", ".cache_loop", ".cache_rate"}) {
            if (reader.find(collider + name) && !reader.find(collider + ".cache"))
                reader.fail(collider + name, "belongs to a cache; name its file with cache");
        }
    }
    for (std::size_t i = 0; i < file.scene.pins.size(); ++i) check_selection_keys(reader, entry("pin", i));
    for (std::size_t i = 0; i < file.scene.seams.size(); ++i) {
        check_selection_keys(reader, entry("seam", i) + ".first");
        check_selection_keys(reader, entry("seam", i) + ".second");
    }
    for (std::size_t i = 0; i < file.scene.events.size(); ++i) {
        const std::string key = entry("event", i) + ".action";
        if (reader.find(key) && !file.scene.events[i].collider)
            reader.fail(key, "acts on a collider; name one with collider");
    }
}

// ---------------------------------------------------------------- pictures

void check_camera(Reader& reader, const CameraDesc& camera) {
    const Vec3 gaze = camera.target - camera.position;
    if (!(gaze.norm() > 1e-9))
        reader.fail("camera.target", "is where the camera stands; it must lie elsewhere");
    if (!(gaze.cross(camera.up).norm() > 1e-3 * gaze.norm() * camera.up.norm()))
        reader.fail("camera.up", "points along the view; it must lie across it");
    if (!camera.path.empty() && camera.framing == Framing::automatic)
        reader.fail("camera.frame",
                    "is \"auto\" beside a path, which says where the camera is; give one of the two");
    for (std::size_t i = 0; i < camera.path.size(); ++i) {
        const CameraKey& key = camera.path[i];
        const std::string place = fmt::format("camera.path[{}]", i);
        if (i > 0 && !(key.time > camera.path[i - 1].time))
            reader.fail(place + ".time", fmt::format("is {:g}; must be later than the key before, {:g} s",
                                                     key.time, camera.path[i - 1].time));
        const Vec3 way = key.target.value_or(camera.target) - key.position.value_or(camera.position);
        if (!(way.norm() > 1e-9)) reader.fail(place, "has its target where it stands; it must lie elsewhere");
        if (!(way.cross(camera.up).norm() > 1e-3 * way.norm() * camera.up.norm()))
            reader.fail(place, "looks along camera.up; it must look across it");
    }
}

void check_pictures(Reader& reader, const SceneFile& file) {
    check_camera(reader, file.camera);
    const render::Float3& light = file.looks.light.direction;
    if (!(Vec3(light[0], light[1], light[2]).norm() > 1e-9))
        reader.fail("light[0].direction", "is zero; must point towards the light");
    const AnnotationDesc& a = file.annotation;
    if (a.shade_range && !a.shade)
        reader.fail("output.shade_range", "belongs to output.shade; name what is shown in colours");
    if (a.shade_range && !((*a.shade_range)[1] > (*a.shade_range)[0]))
        reader.fail("output.shade_range", fmt::format("is [{:g}, {:g}]; the second must be the greater",
                                                      (*a.shade_range)[0], (*a.shade_range)[1]));
}

// ---------------------------------------------------------------- files and the camera

void load_files(Reader& reader, SceneFile& file) {
    for (const Table& table : tables_of(file, file.files)) {
        for (const Field& field : table.fields) {
            const std::string key = table.path + "." + field.key;
            const auto name = file.files.find(key);
            if (!field.load || name == file.files.end()) continue;
            const std::filesystem::path path = reader.find_file(name->second);
            name->second = path.string();
            try {
                for (const std::string& note : field.load(path))
                    file.notes.push_back(fmt::format("{}: {}: {}", key, path.string(), note));
            } catch (const std::runtime_error& error) {
                reader.fail(key, error.what());
            }
        }
    }
}

/// What a cache leaves to be said: the triangles of its mesh, and how long it lasts.
void settle_caches(Reader& reader, SceneFile& file) {
    const double last = (file.output.frames - 1) / file.scene.simulation.frame_rate;
    for (std::size_t i = 0; i < file.scene.colliders.size(); ++i) {
        ColliderDesc& collider = file.scene.colliders[i];
        if (!collider.cache) continue;
        const MeshCache& cache = *collider.cache;
        const std::string key = entry("collider", i) + ".cache";
        if (!collider.mesh && cache.triangles.rows() == 0)
            reader.fail(key, fmt::format("{}: has vertices alone; name the mesh that they move with mesh",
                                         file.files[key]));
        if (!collider.mesh) collider.mesh = MeshData{cache.frames[0], cache.triangles};
        const auto note = [&](const std::string& text) {
            file.notes.push_back(fmt::format("{}: {}: {}", key, file.files[key], text));
        };
        if (cache.times.empty() && !collider.cache_rate)
            note(fmt::format(
                "does not say its frame rate; taken as {:g} frames per second, which cache_rate changes",
                usual_cache_rate));
        if (const double end = cache_end(collider); end < last - 1e-9)
            note(fmt::format(
                "ends at {:.4g} s, the run at {:.4g} s: its last frame stays (or cache_loop = true)",
                std::max(end, 0.0), last));
    }
}

/// OpenGL's view and projection matrices of the scene's camera, without the C library's tangent.
void look_through(const CameraDesc& camera, std::vector<DragDesc>& drags) {
    const Vec3 forward = (camera.target - camera.position).normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    const Vec3 up = right.cross(forward);
    Mat4 view = Mat4::Identity();
    view.block<1, 3>(0, 0) = right.transpose();
    view.block<1, 3>(1, 0) = up.transpose();
    view.block<1, 3>(2, 0) = -forward.transpose();
    view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.position;
    constexpr double near_plane = 0.01, far_plane = 100.0;
    for (DragDesc& drag : drags) {
        const double scale = 1.0 / tan_degrees(0.5 * camera.field_of_view);
        Mat4& p = drag.projection;
        p.setZero();
        p(0, 0) = scale * drag.viewport.y() / drag.viewport.x();
        p(1, 1) = scale;
        p(2, 2) = -(far_plane + near_plane) / (far_plane - near_plane);
        p(2, 3) = -2.0 * far_plane * near_plane / (far_plane - near_plane);
        p(3, 2) = -1.0;
        drag.view = view;
    }
}

// ---------------------------------------------------------------- the simulation's own rules

/// `last`: time of the run's last frame [s].
void check_scene(const Scene& scene, const std::vector<MeshData>& rest, double last) {
    require_start_within_limits(scene, rest);
    require_reachable_pins(scene, rest, last);
    const auto selected = [&](const VertexSelection& selection, int cloth, const std::string& key) {
        const ClothDesc& c = scene.cloths[cloth];
        return select_vertices(selection, c, rest[cloth], start_positions(c, rest[cloth]), key).size();
    };
    for (std::size_t i = 0; i < scene.seams.size(); ++i) {
        const auto& [first, second] = scene.seams[i].sides;
        const std::string key = entry("seam", i);
        const std::size_t a = selected(first, first.cloth, key + ".first"),
                          b = selected(second, second.cloth, key + ".second");
        if (a != b)
            throw SceneError(key + ".second", fmt::format("has {} vertices, the first side {}; a seam "
                                                          "sews one to one, so give as many",
                                                          b, a));
    }
}

std::vector<MeshData> checked_rest_shapes(const Scene& scene) {
    validate(scene);
    std::vector<MeshData> rest;
    for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
        rest.push_back(rest_shape(scene.cloths[i]));
        if (scene.cloths[i].mesh) check_cloth_mesh(rest.back(), entry("cloth", i) + ".mesh");
        if (scene.cloths[i].rest == RestShape::uv) check_uv(rest.back(), entry("cloth", i) + ".rest");
    }
    return rest;
}

/// Lengths that follow the cloths' sizes where nothing is said.
void settle_lengths(SceneFile& file, const std::vector<MeshData>& rest) {
    cloth::settle_lengths(file.scene, rest);
    constexpr double usual_hem = 2e-3, widest_hem = 0.1;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        std::optional<double>& hem = file.looks.cloths[i].hem;
        if (!hem) hem = std::min(usual_length(usual_hem, rest[i]), widest_hem);
    }
}

/// Refuses limits that no run can keep.
void check_limits(const SceneFile& file) {
    if (!file.expect.min_gap) return;
    const SimulationDesc& simulation = file.scene.simulation;
    const std::string gap = fmt::format("{:g} m cannot hold: ", *file.expect.min_gap);
    if (simulation.contact != ContactKind::barrier)
        throw SceneError("expect.min_gap", gap + "only contact = \"barrier\" knows of gaps");
    if (simulation.contact_activation && *file.expect.min_gap >= *simulation.contact_activation)
        throw SceneError("expect.min_gap",
                         gap + fmt::format("surfaces come as near as simulation.contact_activation, {:g} m "
                                           "here, before anything keeps them apart; give less",
                                           *simulation.contact_activation));
}

}  // namespace

void resolve(Reader& reader, SceneFile& file) {
    check_keys(reader, file);
    load_files(reader, file);
    settle_caches(reader, file);
    mend_meshes(reader, file);
    check_pictures(reader, file);
    look_through(file.camera, file.scene.drags);
    try {
        require_memory(reading_need(file.scene), available_memory());
        const std::vector<MeshData> rest = checked_rest_shapes(file.scene);
        settle_lengths(file, rest);
        check_limits(file);
        check_scene(file.scene, rest, (file.output.frames - 1) / file.scene.simulation.frame_rate);
    } catch (const SceneError& error) {
        reader.fail(error.key, error.what());
    }
    note_sizes(file);
}

}  // namespace cloth::pipeline
