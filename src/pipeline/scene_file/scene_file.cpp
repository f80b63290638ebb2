#include "pipeline/scene_file/scene_file.h"

#include <algorithm>
#include <cmath>

#include "pipeline/scene_file/read_scene.h"

namespace cloth::pipeline {

render::Float3 Color::linear() const {
    render::Float3 result{};
    for (int i = 0; i < 3; ++i) {
        const double c = srgb(i);
        result[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return result;
}

namespace {

render::Float3 to_float(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

render::Material material_of(const LookDesc& look) {
    render::Material m;
    m.front = look.color.linear();
    m.back = look.back_color.value_or(look.color).linear();
    m.roughness = static_cast<float>(look.roughness);
    m.specular = static_cast<float>(look.specular);
    m.sheen = static_cast<float>(look.sheen);
    return m;
}

Look cloth_look(const ClothLookDesc& look) {
    render::Material m = material_of(look);
    m.pattern = look.texture ? render::Pattern::image : look.pattern.value_or(render::Pattern::plain);
    m.pattern_scale = static_cast<float>(look.pattern_scale);
    for (std::size_t i = 0; i < m.pattern_colors.size(); ++i)
        m.pattern_colors[i] = look.pattern_colors[std::min(i, look.pattern_colors.size() - 1)].linear();
    m.pattern_on_back = !look.back_color;
    m.image = look.texture;
    m.weave = static_cast<float>(look.weave);
    m.weave_depth = static_cast<float>(look.weave_depth);
    return {m, look.subdivisions, look.hem.value_or(0.0)};
}

render::View view_of(const SceneFile& file) {
    const auto& [cloths, colliders, light, ground, background] = file.looks;
    render::View view;
    view.width = file.output.size.width;
    view.height = file.output.size.height;
    view.eye = to_float(file.camera.position);
    view.target = to_float(file.camera.target);
    view.up = to_float(file.camera.up);
    view.field_of_view = static_cast<float>(file.camera.field_of_view);
    view.light = {.direction = light.direction,
                  .color = light.color.linear(),
                  .intensity = light.intensity,
                  .shadow = light.shadow,
                  .softness = light.softness,
                  .angle = light.angle};
    view.background = background.color.linear();
    view.sky = background.sky.linear();
    view.exposure = static_cast<float>(background.exposure);
    view.ambient_occlusion = background.ambient_occlusion;
    return view;
}

/// What the renderer takes of a scene that has been read.
void prepare_rendering(SceneFile& file) {
    file.view = view_of(file);
    if (const auto& ground = file.looks.ground)
        file.ground = render::Ground{static_cast<float>(ground->height), ground->color.linear()};
    for (const ClothLookDesc& look : file.looks.cloths) file.cloth_looks.push_back(cloth_look(look));
    for (const ColliderLookDesc& look : file.looks.colliders)
        file.collider_looks.push_back({material_of(look)});
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& label, const std::filesystem::path& folder,
                      const Overrides& overrides) {
    Reader reader(label, folder);
    reader.parse(text);
    for (const Override& each : overrides) reader.override_key(each);

    SceneFile file;
    file.name = file.scene.name = std::filesystem::path(label).stem().string();
    try {
        static_cast<void>(toml::parse("name = " + Value<std::string>::write(file.name)));
    } catch (const toml::parse_error&) {
        refuse_scene(label + ": the file's name, which names the scene, is not UTF-8 text: rename it");
    }
    read_scene(reader, file);
    resolve(reader, file);
    prepare_rendering(file);
    return file;
}

}  // namespace cloth::pipeline
