#include "pipeline/run/kept_run.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cstddef>
#include <system_error>
#include <utility>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/report.h"
#include "render/image/image.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The resolved scene with the meshes and textures that it names beside it: the folder can be moved, and the
/// originals may go.
void keep_scene(const RunFolder& folder, const SceneFile& file) {
    std::string text = file.resolved;
    struct Edit {
        std::size_t begin, end;
        std::string text;
    };
    std::vector<Edit> edits;
    const auto offset = [&](toml::source_position place) {
        std::size_t at = 0;
        for (toml::source_index line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
        // Columns count code points; continuation bytes of UTF-8 belong to the one before.
        for (toml::source_index column = 1; column < place.column; ++column) do
                ++at;
            while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80);
        return at;
    };
    const toml::table root = toml::parse(text);
    const auto replace = [&](const toml::node& entry, const char* key, const std::string& name) {
        const toml::node* node = entry.as_table()->get(key);
        if (node != nullptr && node->is_string())
            edits.push_back({offset(node->source().begin), offset(node->source().end), '"' + name + '"'});
    };
    const auto keep_mesh = [&](const toml::node& entry, const char* key, const char* stem, std::size_t number,
                               const MeshData& mesh) {
        const std::string name = fmt::format("meshes/{}_{:06d}.obj", stem, number);
        fs::create_directories(folder.meshes());
        write_mesh(mesh, MeshFormat::obj, folder.root() / name);
        replace(entry, key, name);
    };
    const auto* cloths = root["cloth"].as_array();
    for (std::size_t c = 0; cloths != nullptr && c < cloths->size(); ++c) {
        const ClothDesc& desc = file.scene.cloths.at(c);
        const toml::node& entry = *cloths->get(c);
        if (desc.mesh) keep_mesh(entry, "mesh", "rest", c, *desc.mesh);
        if (desc.pose)
            keep_mesh(entry, "pose", "pose", c, {*desc.pose, desc.mesh ? desc.mesh->triangles : Triangles()});
        if (const auto& image = file.cloth_looks.at(c).material.image) {
            const std::string name = fmt::format("textures/cloth_{:06d}.png", c);
            fs::create_directories(folder.textures());
            render::write_png(*image, folder.root() / name);
            replace(entry, "texture", name);
        }
    }
    const auto* colliders = root["collider"].as_array();
    for (std::size_t c = 0; colliders != nullptr && c < colliders->size(); ++c) {
        const ColliderDesc& desc = file.scene.colliders.at(c);
        if (desc.mesh) keep_mesh(*colliders->get(c), "mesh", "collider", c, *desc.mesh);
    }
    std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.begin > b.begin; });
    for (const Edit& edit : edits) text.replace(edit.begin, edit.end - edit.begin, edit.text);
    write_file(folder.scene(), text);
}

}  // namespace

RunFolder start_run(const fs::path& out, const SceneFile& file, const Model& model) {
    RunFolder folder = RunFolder::create(out);
    folder.clear();
    folder.write_manifest({file.name, file.output.frames, build_fingerprint()});
    keep_scene(folder, file);
    write_topology(model, folder.topology());
    return folder;
}

SceneFile load_run_scene(const fs::path& out, const Overrides& overrides) {
    const RunFolder folder = RunFolder::open(out);
    SceneFile file = load_scene(folder.scene().string(), overrides);
    file.name = folder.read_manifest().scene;
    return file;
}

KeptRun open_run(const fs::path& out, const Overrides& overrides) {
    SceneFile file = load_run_scene(out, overrides);
    Model model = build_model(file.scene);
    RunFolder folder = RunFolder::open(out);
    if (!same_topology(read_topology(folder.topology()), model))
        throw Error(
            ExitCode::other,
            folder.scene().string() + ": its cloth is not the one of the kept states; " + "simulate again");
    return {std::move(folder), std::move(file), std::move(model)};
}

std::vector<std::int64_t> kept_frames(const RunFolder& folder, const std::optional<FrameSpan>& span) {
    const std::vector<std::int64_t> kept = folder.kept_states();
    const std::string out = folder.root().string();
    if (kept.empty()) throw Error(ExitCode::other, out + ": keeps no states to draw");
    if (!span) return kept;
    std::vector<std::int64_t> frames;
    for (std::int64_t frame = span->first; frame < span->last; ++frame) {
        if (!std::binary_search(kept.begin(), kept.end(), frame))
            throw Error(ExitCode::usage,
                        fmt::format("--frames {}:{}: the state of frame {} is not kept in {}; kept: {}",
                                    span->first, span->last, frame, out, span_text(kept)));
        frames.push_back(frame);
    }
    return frames;
}

std::string span_text(const std::vector<std::int64_t>& frames) {
    if (frames.empty()) return "none";
    return frames.size() == 1
               ? fmt::format("frame {}", frames.front())
               : fmt::format("{} frames from {} to {}", frames.size(), frames.front(), frames.back());
}

StateReader state_reader(const RunFolder& folder) {
    return [folder](std::int64_t frame) -> std::optional<State> {
        std::error_code ignored;
        if (!fs::exists(folder.state(frame), ignored)) return std::nullopt;
        return read_state(folder.state(frame));
    };
}

RunFacts survey_run(const RunFolder& folder, const SceneFile& file, const Model& model,
                    const std::atomic<bool>* stop) {
    return survey({folder.kept_states(), state_reader(folder), read_frame_reports(folder)}, file, model,
                  stop);
}

}  // namespace cloth::pipeline
