#include "pipeline/scene_file/scene_file.h"

#include <algorithm>

#include "pipeline/scene_file/document.h"
#include "pipeline/scene_file/reader.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

render::Float3 to_float(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& label, const fs::path& folder,
                      const Overrides& overrides) {
    Reader reader(label, folder);
    reader.parse(text);
    for (const Override& each : overrides) reader.override_key(each);

    Document d;
    d.light = LightEntry();
    read_document(reader, d);
    d.output.width = d.size.width;
    d.output.height = d.size.height;
    resolve(reader, d);

    SceneFile file;
    file.name = fs::path(label).stem().string();
    file.description = d.description;
    d.scene.name = file.name;
    file.scene = d.scene;
    file.output = d.output;
    file.expect = d.expect;
    for (int frame : file.expect.frames) {
        file.expect.frames_simulated = std::max(file.expect.frames_simulated, frame + 1);
    }
    file.view.width = d.size.width;
    file.view.height = d.size.height;
    file.view.eye = to_float(d.camera.position);
    file.view.target = to_float(d.camera.target);
    file.view.up = to_float(d.camera.up);
    file.view.field_of_view = static_cast<float>(d.camera.field_of_view);
    file.camera = d.camera;
    file.annotation = d.annotation;
    file.annotation.caption = d.caption.text;
    file.view.light.direction = to_float(d.light.direction);
    file.view.light.color = d.light.color.linear();
    file.view.light.intensity = static_cast<float>(d.light.intensity);
    file.view.light.softness = static_cast<float>(d.light.softness);
    file.view.light.angle = static_cast<float>(d.light.angle);
    file.view.light.shadow = d.light.shadow;
    file.view.background = d.background.color.linear();
    file.view.sky = d.background.sky.linear();
    file.view.exposure = static_cast<float>(d.background.exposure);
    file.view.ambient_occlusion = d.background.ambient_occlusion;
    if (d.ground)
        file.ground = render::Ground{static_cast<float>(d.ground->height), d.ground->color.linear()};
    for (const ClothEntry& c : d.cloths) file.cloth_looks.push_back(c.cloth_look());
    for (const ColliderEntry& c : d.colliders) file.collider_looks.push_back(c.look.look());
    file.resolved = write_document(d);
    return file;
}

}  // namespace cloth::pipeline
