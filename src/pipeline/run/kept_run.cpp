#include "pipeline/run/kept_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/mesh_cache_file.h"
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
        write_if_changed(folder.root() / kept[key], obj_text(mesh));
    };
    for (std::size_t c = 0; c < file.scene.cloths.size(); ++c) {
        const ClothDesc& desc = file.scene.cloths[c];
        const std::string key = fmt::format("cloth[{}].", c);
        if (desc.mesh) keep_mesh(key + "mesh", "rest", c, *desc.mesh);
        if (desc.pose)
            keep_mesh(key + "pose", "pose", c,
                      {*desc.pose, desc.mesh ? desc.mesh->triangles : Triangles(), {}, {}});
        if (const auto& image = file.cloth_looks.at(c).material.image) {
            kept[key + "texture"] = fmt::format("textures/cloth_{:06d}.png", c);
            fs::create_directories(folder.textures());
            const std::vector<std::uint8_t> png = render::encode_png(*image);
            write_if_changed(folder.root() / kept[key + "texture"],
                             {reinterpret_cast<const char*>(png.data()), png.size()});
        }
    }
    for (std::size_t c = 0; c < file.scene.colliders.size(); ++c) {
        const ColliderDesc& desc = file.scene.colliders[c];
        if (desc.mesh) keep_mesh(fmt::format("collider[{}].mesh", c), "collider", c, *desc.mesh);
        if (desc.cache) {
            const std::string key = fmt::format("collider[{}].cache", c);
            kept[key] = fmt::format("meshes/cache_{:06d}.npz", c);
            write_mesh_cache(*desc.cache, folder.root() / kept[key]);
        }
    }
    write_if_changed(folder.scene(), file.resolved(kept));
    // Those of another scene.
    std::set<fs::path> own;
    for (const auto& [key, name] : kept) own.insert(folder.root() / name);
    for (const fs::path& each : folder.files()) {
        const fs::path parent = each.parent_path();
        if ((parent == folder.meshes() || parent == folder.textures()) && !own.contains(each))
            folder.remove(each);
    }
    std::error_code full;
    fs::remove(folder.meshes(), full);
    fs::remove(folder.textures(), full);
}

/// Whether `path` lies in `folder`, by whatever name or link.
bool lies_in(const fs::path& path, const fs::path& folder) {
    std::error_code failure;
    const fs::path whole = fs::weakly_canonical(path, failure), root = fs::weakly_canonical(folder, failure);
    return std::mismatch(root.begin(), root.end(), whole.begin(), whole.end()).first == root.end();
}

/// Why a state is not one of the model's; empty: it is.
std::string misfit(const State& state, const State& start) {
    const auto differ = [](auto a, auto b, const char* what) {
        return a == b ? std::string() : fmt::format("has {} {}, the scene {}", a, what, b);
    };
    for (const std::string& fault :
         {differ(state.positions.size() / 3, start.positions.size() / 3, "vertices"),
          differ(state.velocities.size() / 3, start.velocities.size() / 3, "velocities"),
          differ(state.collider_on.size(), start.collider_on.size(), "colliders"),
          differ(state.drags.size(), start.drags.size(), "drags"),
          differ(state.rest_folds.size(), start.rest_folds.size(), "creased folds")})
        if (!fault.empty()) return fault;
    for (const DragState& drag : state.drags) {
        if (drag.vertices.size() != drag.anchors.size()) return "holds vertices without anchors";
        for (const int vertex : drag.vertices)
            if (vertex < 0 || vertex >= start.positions.size() / 3)
                return fmt::format("holds vertex {}, the scene has {}", vertex, start.positions.size() / 3);
    }
    if (!std::isfinite(state.time)) return "has a time that is no number";
    return {};
}

}  // namespace

void require_place(const fs::path& out, const SceneFile& file, const std::string& flag) {
    require_own_folder(out, flag);
    try {
        [[maybe_unused]] const std::string text = nlohmann::json(file.name).dump();
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::invalid_scene, file.path.string() + ": its name is no UTF-8 text; rename it");
    }
    const auto require_outside = [&](const fs::path& read) {
        if (!read.empty() && lies_in(read, out))
            throw Error(ExitCode::usage,
                        fmt::format("{} {}: {} is read from there; give another folder, whose files may be "
                                    "replaced",
                                    flag, out.string(), read.string()));
    };
    require_outside(file.path);
    for (const auto& [key, name] : file.files) require_outside(name);
}

StartedRun start_run(const fs::path& out, const Wanted& wanted, const RunOptions& options) {
    const SceneFile& file = wanted.file;
    require_place(out, file);
    RunFolder folder = RunFolder::create(out);
    const auto tell = [&](const std::string& line) {
        if (options.tell) options.tell(line);
    };
    const Manifest manifest{file.name, wanted.frames, maker(), state_format, wanted.trunk.keys};
    if (options.fresh) {
        const auto states = std::ssize(folder.states_on_disk()), images = std::ssize(folder.images_on_disk());
        if (states + images > 0)
            tell(fmt::format("--fresh: {} and {} in {} replaced", plural(states, "state"),
                             plural(images, "picture"), out.string()));
        folder.clear();
        folder.write_manifest(manifest);
    }
    RunPlan plan = plan_run(folder, wanted);
    for (const std::string& line : plan.warnings) tell(line);
    const bool complete = plan.outdated.empty() && plan.kept_states() == wanted.frames &&
                          (!wanted.pictures || plan.kept_pictures() == wanted.frames) &&
                          (!wanted.movie || plan.has_movie) && folder.has_manifest() &&
                          folder.read_manifest().frames == wanted.frames;
    if (!complete) {
        // The scene goes first: without it nothing is drawn from what is left, if this ends here.
        if (!plan.outdated.empty()) folder.remove(folder.scene());
        for (const fs::path& each : plan.outdated) folder.remove(each);
        for (const fs::path& each : folder.parts()) folder.remove(each);
        for (const fs::path& each :
             {folder.report(), folder.certificate(), folder.page(), folder.sheet(), folder.overlap()})
            folder.remove(each);
    }
    folder.write_manifest(manifest);
    auto ledger = std::make_unique<Ledger>(folder.ledger(), plan.kept, options.sync);
    const std::string before = file_fingerprint(folder.scene());
    keep_scene(folder, file);
    write_topology(wanted.model, folder.topology());
    const bool finished = complete && before == file_fingerprint(folder.scene());
    return {std::move(folder), std::move(plan), std::move(ledger), finished};
}

SceneFile load_run_scene(const fs::path& out, const Overrides& overrides) {
    const RunFolder folder = RunFolder::open(out);
    SceneFile file = load_scene(folder.scene().string(), overrides);
    file.name = folder.read_manifest().scene;
    return file;
}

KeptRun open_run(const fs::path& out, const Overrides& overrides) {
    RunFolder folder = RunFolder::open(out);
    const Manifest manifest = folder.read_manifest();
    if (manifest.format != state_format)
        throw Error(ExitCode::other, fmt::format("{}: its states are of format {}, this program reads {}; "
                                                 "simulate again",
                                                 out.string(), manifest.format, state_format));
    SceneFile file = load_run_scene(out, overrides);
    Model model = build_model(file.scene);
    if (!same_topology(read_topology(folder.topology()), model))
        throw Error(ExitCode::other, folder.scene().string() +
                                         ": its cloth is not the one of the kept states; simulate again");
    return {std::move(folder), std::move(file), std::move(model), manifest.frames};
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

std::string state_fault(const State& state) {
    constexpr double furthest = 1e9;  // [m]
    if (const int vertex = first_non_finite_vertex(state); vertex >= 0)
        return fmt::format("vertex {} is no longer finite", vertex);
    for (Eigen::Index i = 0; i < state.positions.size(); ++i) {
        if (std::abs(state.positions[i]) > furthest)
            return fmt::format("vertex {} is more than {:g} m away", i / 3, furthest);
    }
    return {};
}

StateReader state_reader(const RunFolder& folder, const Model& model) {
    return [folder, start = start_state(model)](std::int64_t frame) -> std::optional<State> {
        const fs::path path = folder.state(frame);
        std::error_code ignored;
        if (!fs::exists(path, ignored)) return std::nullopt;
        State state = read_state(path);
        std::string fault = misfit(state, start);
        if (fault.empty() && state.frame != frame)
            fault = fmt::format("is the state of frame {}", state.frame);
        if (fault.empty()) fault = state_fault(state);
        if (!fault.empty())
            throw Error(ExitCode::other, fmt::format("{}: {}; simulate again", path.string(), fault));
        return state;
    };
}

State read_kept(const StateReader& read, std::int64_t frame) {
    std::optional<State> state = read(frame);
    if (!state) throw Error(ExitCode::other, fmt::format("the state of frame {} is gone", frame));
    return std::move(*state);
}

std::vector<std::int64_t> movie_frames(const KeptRun& run) {
    const std::string out = run.folder.root().string();
    const std::vector<std::int64_t> states = run.folder.kept_states(), images = run.folder.kept_images();
    const auto gap = [](const std::vector<std::int64_t>& frames) {
        std::int64_t next = 0;
        while (std::cmp_less(next, frames.size()) && frames[static_cast<std::size_t>(next)] == next) ++next;
        return next;
    };
    const std::int64_t first_missing = gap(states);
    if (states.empty() || std::cmp_less(first_missing, states.size()))
        throw Error(ExitCode::other,
                    fmt::format("{}: the state of frame {} is missing: no movie; simulate again with "
                                "render_cloth simulate --scene {} --out NEW_FOLDER",
                                out, first_missing, run.folder.scene().string()));
    if (std::cmp_greater(states.size(), run.frames))
        throw Error(ExitCode::other, fmt::format("{}: has states of {} frames, its manifest tells of {}: no "
                                                 "movie",
                                                 out, states.size(), run.frames));
    std::vector<std::int64_t> frames;
    std::set_intersection(states.begin(), states.end(), images.begin(), images.end(),
                          std::back_inserter(frames));
    if (frames != states)
        throw Error(ExitCode::other, fmt::format("{0}: has pictures of {1} of its {2} frames: no movie; draw "
                                                 "the rest with render_cloth render --out {0}",
                                                 out, frames.size(), states.size()));
    if (images != states)
        throw Error(ExitCode::other, fmt::format("{}: {} has no state: no movie; remove it", out,
                                                 run.folder.image(images.back()).string()));
    return frames;
}

RunFacts survey_run(const RunFolder& folder, const SceneFile& file, const Model& model,
                    const std::atomic<bool>* stop) {
    return survey({folder.kept_states(), state_reader(folder, model), read_frame_reports(folder)}, file,
                  model, stop);
}

}  // namespace cloth::pipeline
