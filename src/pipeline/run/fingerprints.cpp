#include "pipeline/run/fingerprints.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/picture/survey.h"

namespace cloth::pipeline {

namespace {

std::string text_of(const SceneFile& file) {
    std::string text;
    for (const auto& [key, value] : values_of(file))
        text += fmt::format("{} {}\n{}\n", key, value.size(), value);
    return text;
}

/// Bits, not digits.
std::string bytes_of(const Mat4& m) {
    return {reinterpret_cast<const char*>(m.data()), sizeof(double) * 16};
}

std::string physics_key(const SceneFile& file) {
    std::string text = build_fingerprint() + '\n' + physics_sources() + '\n' + text_of(physics_of(file));
    // A drag looks through the camera.
    for (const DragDesc& drag : file.scene.drags) text += bytes_of(drag.view) + bytes_of(drag.projection);
    return fingerprint(text);
}

std::string chained(const std::string& before, const std::string& more) {
    return fingerprint(before + '\n' + more);
}

std::string text_of(const EventDesc& event) {
    return fmt::format("{:a} {} {} {} {};", event.time, event.collider.value_or(-1),
                       static_cast<int>(event.action), event.toggle_integrator,
                       event.integrator ? static_cast<int>(*event.integrator) : -1);
}

}  // namespace

std::string scene_key(const SceneFile& file) {
    return fingerprint(text_of(file));
}

SceneFile physics_of(const SceneFile& file) {
    SceneFile part;
    part.scene = file.scene;
    part.scene.events.clear();
    for (ColliderDesc& collider : part.scene.colliders) collider.drawn = true;
    part.looks.cloths.resize(file.scene.cloths.size());
    part.looks.colliders.resize(file.scene.colliders.size());
    return part;
}

SceneFile look_of(const SceneFile& file) {
    SceneFile part = file;
    part.scene.simulation = {};
    part.scene.simulation.frame_rate = file.scene.simulation.frame_rate;
    part.scene.parts.clear();
    part.scene.pins.clear();
    part.scene.seams.clear();
    part.scene.drags.clear();
    part.scene.events.clear();
    const OutputDesc usual;
    part.output.frames = usual.frames;
    part.output.preview_frames = usual.preview_frames;
    part.output.playback_rate = usual.playback_rate;
    part.output.quality = usual.quality;
    part.expect = {};
    if (!file.annotation.caption) part.name = part.scene.name = part.description = "";
    return part;
}

std::uint32_t events_before(const Model& model, std::int64_t frame) {
    // As advance() has it: from the first step that starts at or after its time, rounding apart.
    constexpr double slack = 1e-9;
    if (frame == 0) return 0;
    const double last_start = static_cast<double>(frame * model.steps_per_frame - 1) * model.time_step;
    const auto& events = model.scene.events;
    return static_cast<std::uint32_t>(
        std::find_if(events.begin(), events.end(),
                     [&](const EventDesc& e) { return e.time > last_start + slack; }) -
        events.begin());
}

std::vector<std::string> state_keys(const SceneFile& file, const Model& model, std::int64_t frames,
                                    const Trunk& trunk) {
    std::vector<std::string> keys = trunk.keys;
    keys.resize(std::min(keys.size(), static_cast<std::size_t>(frames)));
    if (keys.empty() && frames > 0) keys.push_back(physics_key(file));
    while (static_cast<std::int64_t>(keys.size()) < frames) {
        const auto frame = static_cast<std::int64_t>(keys.size());
        std::string acting;
        for (std::uint32_t e = events_before(model, frame - 1); e < events_before(model, frame); ++e)
            acting += text_of(model.scene.events[e]);
        keys.push_back(chained(keys.back(), acting));
    }
    return keys;
}

std::string branch_key(const SceneFile& file, const std::string& key) {
    return chained(key, "branch " + physics_key(file));
}

std::vector<std::string> picture_keys(const SceneFile& file, const std::vector<std::string>& states,
                                      std::int64_t frames) {
    const SceneFile look = look_of(file);
    const std::string look_key = fingerprint(all_sources() + '\n' + look.name + '\n' + text_of(look));
    const std::string run =
        needs_whole_run(file) && frames > 0
            ? fmt::format("{} of {}", states.at(static_cast<std::size_t>(frames) - 1), frames)
            : std::string();
    // Fields may ask the model for more than the look has.
    const std::string physics = file.annotation.shade ? physics_key(file) : std::string();
    std::vector<std::string> keys;
    for (const std::string& state : states) keys.push_back(chained(look_key + run + physics, state));
    return keys;
}

std::string movie_key(const SceneFile& file, const std::vector<std::string>& pictures, std::int64_t frames,
                      double playback_rate) {
    std::string text = fmt::format("{} {:a} {}\n", file.output.quality, playback_rate, all_sources());
    for (std::int64_t frame = 0; frame < frames; ++frame)
        text += pictures.at(static_cast<std::size_t>(frame));
    return fingerprint(text);
}

}  // namespace cloth::pipeline
