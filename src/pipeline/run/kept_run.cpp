#include "pipeline/run/kept_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <system_error>
#include <utility>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/report.h"
#include "render/image/image.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The resolved scene with the meshes and textures that it names beside it: the folder can be moved, and the
/// originals may go.
void keep_scene(const RunFolder& folder, const SceneFile& file) {
    FileNames kept;
    const auto keep_mesh = [&](const std::string& key, const char* stem, std::size_t number,
                               const MeshData& mesh) {
        kept[key] = fmt::format("meshes/{}_{:06d}.obj", stem, number);
        fs::create_directories(folder.meshes());
        write_file(folder.root() / kept[key], obj_text(mesh));
    };
    for (std::size_t c = 0; c < file.scene.cloths.size(); ++c) {
        const ClothDesc& desc = file.scene.cloths[c];
        const std::string key = fmt::format("cloth[{}].", c);
        if (desc.mesh) keep_mesh(key + "mesh", "rest", c, *desc.mesh);
        if (desc.pose)
            keep_mesh(key + "pose", "pose", c, {*desc.pose, desc.mesh ? desc.mesh->triangles : Triangles()});
        if (const auto& image = file.cloth_looks.at(c).material.image) {
            kept[key + "texture"] = fmt::format("textures/cloth_{:06d}.png", c);
            fs::create_directories(folder.textures());
            render::write_png(*image, folder.root() / kept[key + "texture"]);
        }
    }
    for (std::size_t c = 0; c < file.scene.colliders.size(); ++c) {
        const ColliderDesc& desc = file.scene.colliders[c];
        if (desc.mesh) keep_mesh(fmt::format("collider[{}].mesh", c), "collider", c, *desc.mesh);
    }
    write_file(folder.scene(), file.resolved(kept));
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
    if (kept.empty()) throw Error(ExitCode::other, out + ": keeps no states");
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
