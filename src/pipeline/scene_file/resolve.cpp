// Files, names and numbers of a scene file become what the simulation takes.

#include <set>

#include "base/portable_math.h"
#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/scene_file/document.h"
#include "pipeline/scene_file/reader.h"
#include "sim/model.h"
#include "sim/scene/mesh.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

template <class Entries>
void require_distinct_names(Reader& reader, const char* table, const Entries& entries) {
    std::set<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (!names.insert(entries[i].desc.name).second) {
            reader.fail(entry(table, i) + ".name",
                        fmt::format("\"{}\" is taken; names must differ", entries[i].desc.name));
        }
    }
}

template <class Entries>
int index_of(Reader& reader, const std::string& key, const std::string& name, const Entries& entries,
             const char* what) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (entries[i].desc.name == name) return static_cast<int>(i);
        names.push_back(entries[i].desc.name);
    }
    const std::string near = nearest_word(name, names);
    reader.fail(key, fmt::format("there is no {} \"{}\"; {}", what, name,
                                 !near.empty()   ? fmt::format("did you mean \"{}\"?", near)
                                 : names.empty() ? fmt::format("the scene has none")
                                                 : "known: " + join(names)));
}

template <class Result>
Result load(Reader& reader, const std::string& key, const fs::path& path, Result (*read)(const fs::path&)) {
    try {
        return read(path);
    } catch (const Error& error) {
        reader.fail(key, error.what());
    }
}

void resolve_cloths(Reader& reader, Document& d) {
    require_distinct_names(reader, "cloth", d.cloths);
    for (std::size_t i = 0; i < d.cloths.size(); ++i) {
        ClothEntry& c = d.cloths[i];
        const std::string key = entry("cloth", i);
        if (c.mesh || c.radius) {
            for (const auto& [given, name] :
                 {std::pair{c.size.has_value(), "size"}, std::pair{c.resolution.has_value(), "resolution"},
                  std::pair{c.diagonals.has_value(), "diagonals"}}) {
                if (given) {
                    reader.fail(key + "." + name,
                                fmt::format("belongs to a grid, but the cloth has a {}; give "
                                            "one of the two",
                                            c.mesh ? "mesh" : "radius"));
                }
            }
        }
        if (c.rings && !c.radius) reader.fail(key + ".rings", "belongs to a disc; give its radius too");
        if (c.mesh) {
            if (c.radius) {
                reader.fail(key + ".radius",
                            "belongs to a disc, but the cloth has a mesh; give one of the two");
            }
            const fs::path path = reader.find_file(*c.mesh);
            c.mesh = path.string();
            c.desc.mesh = load(reader, key + ".mesh", path, read_mesh);
        } else if (c.radius) {
            c.desc.disc = Disc{.radius = *c.radius};
            if (c.rings) c.desc.disc->rings = *c.rings;
            c.rings = c.desc.disc->rings;
        } else {
            if (c.size) c.desc.grid.size = *c.size;
            if (c.resolution) c.desc.grid.resolution = c.resolution->count;
            if (c.diagonals) c.desc.grid.diagonals = *c.diagonals;
            c.size = c.desc.grid.size;
            c.resolution = Resolution{c.desc.grid.resolution};
            c.diagonals = c.desc.grid.diagonals;
        }
        if (c.pose) {
            const fs::path path = reader.find_file(*c.pose);
            c.pose = path.string();
            c.desc.pose = load(reader, key + ".pose", path, read_points);
        }
        if (c.texture) {
            if (c.pattern)
                reader.fail(key + ".pattern",
                            "stands beside texture, which takes its place; give one or the other");
            const fs::path path = reader.find_file(*c.texture);
            c.texture = path.string();
            try {
                c.image = std::make_shared<const render::Image>(render::read_png(path));
            } catch (const std::runtime_error& error) {
                reader.fail(key + ".texture", error.what());
            }
        }
        if (c.pattern_colors.empty() || c.pattern_colors.size() > 3)
            reader.fail(key + ".pattern_colors",
                        fmt::format("has {} entries; must be one to three colours", c.pattern_colors.size()));
        d.scene.cloths.push_back(c.desc);
    }
}

void resolve_selection(Reader& reader, const std::string& key, const SelectionEntry& selection,
                       const std::vector<ClothEntry>& cloths, VertexSelection& desc, int& cloth) {
    if (selection.cloth && !selection.cloth->name.empty()) {
        cloth = index_of(reader, key + ".cloth", selection.cloth->name, cloths, "cloth");
    } else if (selection.cloth) {
        cloth = selection.cloth->index;
        if (cloth < 0 || static_cast<std::size_t>(cloth) >= cloths.size()) {
            reader.fail(key + ".cloth", fmt::format("is {}; the scene has {} [[cloth]], counted from 0",
                                                    cloth, cloths.size()));
        }
    }
    if (selection.vertices) {
        if (selection.vertices->empty()) reader.fail(key + ".vertices", "is empty; name at least one vertex");
        desc.vertices = *selection.vertices;
    }
}

void resolve_references(Reader& reader, Document& d) {
    require_distinct_names(reader, "collider", d.colliders);
    for (std::size_t i = 0; i < d.colliders.size(); ++i) {
        ColliderEntry& c = d.colliders[i];
        if (c.mesh) {
            const std::string key = entry("collider", i) + ".mesh";
            if (c.desc.shape != Shape::mesh) reader.fail(key, "belongs to shape = \"mesh\"");
            const fs::path path = reader.find_file(*c.mesh);
            c.mesh = path.string();
            c.desc.mesh = load(reader, key, path, read_mesh);
        }
        d.scene.colliders.push_back(c.desc);
    }
    for (std::size_t i = 0; i < d.pins.size(); ++i) {
        PinEntry& p = d.pins[i];
        resolve_selection(reader, entry("pin", i), p.selection, d.cloths, p.desc, p.desc.cloth);
        d.scene.pins.push_back(p.desc);
    }
    for (std::size_t i = 0; i < d.seams.size(); ++i) {
        SeamEntry& s = d.seams[i];
        for (int side = 0; side < 2; ++side) {
            resolve_selection(reader, entry("seam", i) + "." + seam_sides[side], s.selections[side], d.cloths,
                              s.desc.sides[side], s.desc.sides[side].cloth);
        }
        d.scene.seams.push_back(s.desc);
    }
    for (std::size_t i = 0; i < d.events.size(); ++i) {
        EventEntry& e = d.events[i];
        const std::string key = entry("event", i);
        if (e.collider)
            e.desc.collider = index_of(reader, key + ".collider", *e.collider, d.colliders, "collider");
        if (e.action && !e.collider)
            reader.fail(key + ".action", "acts on a collider; name one with collider");
        e.desc.action = e.action.value_or(Switch::toggle);
        if (e.integrator == "toggle") {
            e.desc.toggle_integrator = true;
        } else if (e.integrator) {
            std::vector<std::string> known{"toggle"};
            for (const auto& [name, value] : integrator_names) {
                known.push_back(name);
                if (*e.integrator == name) e.desc.integrator = value;
            }
            if (!e.desc.integrator) {
                reader.fail(key + ".integrator",
                            fmt::format("is \"{}\"; must be one of {}", *e.integrator, join(known)));
            }
        }
        d.scene.events.push_back(e.desc);
    }
}

void check_camera(Reader& reader, const CameraEntry& camera) {
    if (!camera.path.empty() && camera.framing == Framing::automatic)
        reader.fail("camera.frame",
                    "is \"auto\" beside a path, which says where the camera is; give one of the two");
    for (std::size_t i = 0; i < camera.path.size(); ++i) {
        const CameraKey& key = camera.path[i];
        const std::string place = fmt::format("camera.path[{}]", i);
        if (i > 0 && !(key.time > camera.path[i - 1].time))
            reader.fail(place + ".time", fmt::format("is {:g}; must be later than the key before, {:g} s",
                                                     key.time, camera.path[i - 1].time));
        const Vec3 gaze = key.target.value_or(camera.target) - key.position.value_or(camera.position);
        if (!(gaze.norm() > 1e-9))
            reader.fail(place, "has its target where it stands; it must lie elsewhere");
        if (!(gaze.cross(camera.up).norm() > 1e-3 * gaze.norm() * camera.up.norm()))
            reader.fail(place, "looks along camera.up; it must look across it");
    }
}

void check_annotation(Reader& reader, const AnnotationDesc& a) {
    if (a.shade_range && !a.shade)
        reader.fail("output.shade_range", "belongs to output.shade; name what is shown in colours");
    if (a.shade_range && !((*a.shade_range)[1] > (*a.shade_range)[0]))
        reader.fail("output.shade_range", fmt::format("is [{:g}, {:g}]; the second must be the greater",
                                                      (*a.shade_range)[0], (*a.shade_range)[1]));
}

void check_looks(Reader& reader, Document& d) {
    const Vec3 gaze = d.camera.target - d.camera.position;
    if (!(gaze.norm() > 1e-9))
        reader.fail("camera.target", "is where the camera stands; it must lie elsewhere");
    if (!(gaze.cross(d.camera.up).norm() > 1e-3 * gaze.norm() * d.camera.up.norm())) {
        reader.fail("camera.up", "points along the view; it must lie across it");
    }
    check_camera(reader, d.camera);
    if (!(d.light.direction.norm() > 1e-9))
        reader.fail("light[0].direction", "is zero; must point towards the light");
    check_annotation(reader, d.annotation);
}

/// OpenGL's view and projection matrices of the scene's camera, without the C library's tangent.
void resolve_drags(Document& d) {
    const CameraEntry& camera = d.camera;
    const Vec3 forward = (camera.target - camera.position).normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    const Vec3 up = right.cross(forward);
    Mat4 view = Mat4::Identity();
    view.block<1, 3>(0, 0) = right.transpose();
    view.block<1, 3>(1, 0) = up.transpose();
    view.block<1, 3>(2, 0) = -forward.transpose();
    view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.position;
    constexpr double near_plane = 0.01, far_plane = 100.0;
    for (DragEntry& drag : d.drags) {
        const double scale = 1.0 / tan_degrees(0.5 * camera.field_of_view);
        Mat4& p = drag.desc.projection;
        p.setZero();
        p(0, 0) = scale * drag.desc.viewport.y() / drag.desc.viewport.x();
        p(1, 1) = scale;
        p(2, 2) = -(far_plane + near_plane) / (far_plane - near_plane);
        p(2, 3) = -2.0 * far_plane * near_plane / (far_plane - near_plane);
        p(3, 2) = -1.0;
        drag.desc.view = view;
        d.scene.drags.push_back(drag.desc);
    }
}

/// What the simulation asks of a scene, and whether its meshes and selections are good.
void check_scene(Reader& reader, const Document& d) {
    try {
        validate(d.scene);
        for (std::size_t i = 0; i < d.scene.cloths.size(); ++i) {
            if (d.scene.cloths[i].mesh)
                check_cloth_mesh(*d.scene.cloths[i].mesh, entry("cloth", i) + ".mesh");
        }
        const auto selected = [&](const VertexSelection& selection, int cloth, const std::string& key) {
            const ClothDesc& c = d.scene.cloths[cloth];
            return select_vertices(selection, start_positions(c, rest_shape(c)), key, c.rest_grid()).size();
        };
        for (std::size_t i = 0; i < d.scene.pins.size(); ++i)
            selected(d.scene.pins[i], d.scene.pins[i].cloth, entry("pin", i));
        for (std::size_t i = 0; i < d.scene.seams.size(); ++i) {
            const auto& [first, second] = d.scene.seams[i].sides;
            const std::string key = entry("seam", i);
            const std::size_t a = selected(first, first.cloth, key + ".first"),
                              b = selected(second, second.cloth, key + ".second");
            if (a != b)
                throw SceneError(key + ".second", fmt::format("has {} vertices, the first side {}; a seam "
                                                              "sews one to one, so give as many",
                                                              b, a));
        }
    } catch (const SceneError& error) {
        reader.fail(error.key, error.what());
    }
}

}  // namespace

void resolve(Reader& reader, Document& d) {
    resolve_cloths(reader, d);
    resolve_references(reader, d);
    check_looks(reader, d);
    resolve_drags(d);
    check_scene(reader, d);
}

}  // namespace cloth::pipeline
