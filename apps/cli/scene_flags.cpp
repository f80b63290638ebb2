#include "apps/cli/scene_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <system_error>

#include "base/text.h"
#include "pipeline/scene_file/picture_desc.h"
#include "sim/fields/vertex_fields.h"

namespace cloth::cli {

using pipeline::Override;
using pipeline::Overrides;

namespace {

std::string as_typed(const std::string& text) {
    return text;
}
/// 64x48 → [64, 48]
template <char separator>
std::string array(const std::string& text) {
    return fmt::format("[{}]", fmt::join(split(text, separator), ", "));
}
/// a,b → ["a", "b"]
std::string names(const std::string& text) {
    return fmt::format("[\"{}\"]", fmt::join(split(text, ','), "\", \""));
}

template <class Names>
std::string name_list(const Names& names) {
    std::string text;
    for (const auto& each : names) text += fmt::format("{}{}", text.empty() ? "" : ", ", each.name);
    return text;
}

}  // namespace

void KeyFlags::forward(Flags& flags, const Flag& flag, const std::string& key, Form form) {
    forwarded_.push_back({flag.name, key, form, ""});
    flags.text(flag, forwarded_.back().text);
}

void KeyFlags::add_set(Flags& flags) {
    flags.repeated({"--set", "KEY=VALUE", "Override a key of the scene; may be repeated"}, set_);
}

void KeyFlags::add_frames(Flags& flags, const std::string& value, const std::string& help) {
    flags.text({"--frames", value, help}, frames_);
}

void KeyFlags::add_preview(Flags& flags) {
    flags.yes("--preview", preview_, "Short and small: output.preview_frames frames of 480x270");
}

void KeyFlags::add_size(Flags& flags) {
    forward(flags, {"--size", "WxH", "Size of the pictures"}, "output.size", array<'x'>);
}

void KeyFlags::add_fps(Flags& flags) {
    flags.text({"--fps", "F", "Frames per second of the movie"}, fps_);
}

void KeyFlags::add_annotation(Flags& flags) {
    flags.yes("--caption", caption_, "Scene, time and frame in the picture");
    forward(flags, {"--shade", "WHAT", "Colours for " + name_list(vertex_field_names())}, "output.shade",
            as_typed);
    forward(flags, {"--shade-range", "LOW:HIGH", "Ends of the colours (default: of the whole run)"},
            "output.shade_range", array<':'>);
    flags.yes("--wireframe", wireframe_, "The edges of the simulated triangles");
    forward(flags, {"--ids", "X,Y[,R]", "Vertex and triangle numbers at a pixel"}, "output.ids", array<','>);
    forward(flags, {"--curves", "A,B,…", "Draw curves of " + name_list(pipeline::curve_names)},
            "output.curves", names);
    forward(flags, {"--motion-blur", "K", "Each frame is the mean of K pictures"}, "output.motion_blur",
            as_typed);
}

Overrides KeyFlags::overrides() const {
    Overrides list;
    for (const std::string& each : set_) {
        if (each.find('=') == std::string::npos || each.front() == '=')
            refuse("--set " + each + ": give KEY=VALUE, as in cloth.resolution=40");
        list.push_back(each);
    }
    for (const Forwarded& each : forwarded_)
        if (!each.text.empty())
            list.push_back({each.key + "=" + each.form(each.text), each.flag + " " + each.text});
    if (caption_) list.push_back({"output.caption=true", "--caption"});
    if (wireframe_) list.push_back({"output.wireframe=true", "--wireframe"});
    return list;
}

Overrides KeyFlags::redraw_overrides() const {
    Overrides list = overrides();
    if (!fps_.empty()) list.push_back({"output.playback_rate=" + fps_, "--fps " + fps_});
    return list;
}

pipeline::SceneFile KeyFlags::load(const std::string& name_or_path) const {
    Overrides list = overrides();
    if (preview_) {
        const pipeline::OutputDesc asked = pipeline::load_scene(name_or_path, list).output;
        const int frames = std::min(asked.preview_frames, asked.frames);
        list.insert(list.begin(), {{fmt::format("output.frames={}", frames), "--preview"},
                                   {"output.size=[480, 270]", "--preview"}});
    }
    if (!frames_.empty()) list.push_back({"output.frames=" + frames_, "--frames " + frames_});
    if (fps_.empty()) return pipeline::load_scene(name_or_path, list);
    const bool own_rate = pipeline::load_scene(name_or_path, list).output.playback_rate.has_value();
    const std::string key = own_rate ? "output.playback_rate" : "simulation.frame_rate";
    list.push_back({key + "=" + fps_, "--fps " + fps_});
    return pipeline::load_scene(name_or_path, list);
}

pipeline::SceneFile KeyFlags::load_run(const std::filesystem::path& out) const {
    Overrides list = redraw_overrides();
    const std::int64_t frames = pipeline::RunFolder::open(out).read_manifest().frames;
    if (frames_.empty())
        list.insert(list.begin(), fmt::format("output.frames={}", frames));
    else
        list.push_back({"output.frames=" + frames_, "--frames " + frames_});
    return pipeline::load_run_scene(out, list);
}

std::optional<pipeline::FrameSpan> KeyFlags::span() const {
    if (frames_.empty()) return std::nullopt;
    pipeline::FrameSpan span;
    const char* const end = frames_.data() + frames_.size();
    const auto [colon, bad_first] = std::from_chars(frames_.data(), end, span.first);
    if (bad_first == std::errc() && colon != end && *colon == ':') {
        const auto [rest, bad_last] = std::from_chars(colon + 1, end, span.last);
        if (bad_last == std::errc() && rest == end && span.first >= 0 && span.last > span.first) return span;
    }
    refuse("--frames " + frames_ + ": give A:B with 0 <= A < B, for the frames A … B-1");
}

bool KeyFlags::has_size() const {
    return std::any_of(forwarded_.begin(), forwarded_.end(),
                       [](const Forwarded& each) { return each.flag == "--size" && !each.text.empty(); });
}

void SceneFlags::add(Flags& flags) {
    flags.text({"--scene", "NAME|FILE", "Scene, by name or TOML file"}, scene);
    keys.add_frames(flags, "N", "Number of frames; frame 0 is the start pose");
    flags.text({"--out", "DIR", "Folder of the run (default: out/NAME)"}, out);
    keys.add_size(flags);
    keys.add_preview(flags);
    keys.add_fps(flags);
    keys.add_set(flags);
}

pipeline::SceneFile SceneFlags::load() const {
    if (scene.empty())
        refuse("--scene is missing: give a scene's name or file; render_cloth list names them");
    const pipeline::SceneFile file = keys.load(scene);
    for (const std::string& note : file.notes) fmt::print(stderr, "render_cloth: note: {}\n", one_line(note));
    return file;
}

std::filesystem::path SceneFlags::folder(const pipeline::SceneFile& file) const {
    return out.empty() ? std::filesystem::path("out") / file.name : std::filesystem::path(out);
}

}  // namespace cloth::cli
