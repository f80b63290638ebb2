#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/picture/camera.h"
#include "pipeline/picture/rest_chart.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// Texture coordinates: repeats of the pattern or texture where pictures show one, else the box of the rest
/// shape in 0 … 1, its longer side from end to end.
TexturePoints texture_points(const Points& rest, const Triangles& triangles,
                             const render::Material& material) {
    TexturePoints uv = rest_chart(rest, triangles);
    if (material.pattern != render::Pattern::plain) return uv / material.pattern_scale;
    const Eigen::RowVector2d low = uv.colwise().minCoeff(), size = uv.colwise().maxCoeff() - low;
    return (uv.rowwise() - low) / std::max(size.maxCoeff(), 1e-30);
}

/// All cloths, or the one of this name.
std::vector<std::size_t> chosen_cloths(const Topology& topology, const std::string& cloth) {
    std::vector<std::size_t> chosen;
    std::vector<std::string> names;
    for (std::size_t c = 0; c < topology.cloths.size(); ++c) {
        names.push_back(topology.cloths[c].name);
        if (cloth.empty() || names.back() == cloth) chosen.push_back(c);
    }
    if (chosen.empty())
        throw Error(ExitCode::usage, fmt::format("--cloth {}: the run has no cloth of this name; it has {}",
                                                 cloth, join(names)));
    return chosen;
}

/// Those of a span, all of which must be kept, or all.
std::vector<std::int64_t> chosen_frames(const RunFolder& folder, const std::optional<FrameSpan>& span) {
    if (span && span->last - span->first == 1) {
        const auto kept = folder.kept_states();
        if (!std::binary_search(kept.begin(), kept.end(), span->first))
            throw Error(ExitCode::usage, fmt::format("--frame {}: its state is not kept in {}; kept: {}",
                                                     span->first, folder.root().string(), span_text(kept)));
    }
    return kept_frames(folder, span);
}

/// A kept run as exporters are told of it.
class ExportedRun {
  public:
    ExportedRun(const fs::path& out, const ExportChoice& choice, const std::atomic<bool>* stop)
        : run_(open_run(out)), topology_(read_topology(run_.folder.topology())), fields_(run_.model) {
        const SceneFile& file = run_.file;
        const auto chosen = chosen_cloths(topology_, choice.cloth);
        first_ = topology_.cloths[chosen.front()].first_vertex;
        const ClothRange &from = topology_.cloths[chosen.front()], &to = topology_.cloths[chosen.back()];
        const int n = to.first_vertex + to.vertex_count - first_;
        scene_.name = one_line(file.name);
        scene_.topology.rest_positions = topology_.rest_positions.middleRows(first_, n);
        scene_.topology.triangles =
            topology_.triangles
                .middleRows(from.first_triangle, to.first_triangle + to.triangle_count - from.first_triangle)
                .array() -
            first_;
        scene_.uv.resize(n, 2);
        for (const std::size_t c : chosen) {
            ClothRange cloth = topology_.cloths[c];
            cloth.name = one_line(cloth.name);
            cloth.first_vertex -= first_;
            cloth.first_triangle -= from.first_triangle;
            scene_.topology.cloths.push_back(cloth);
            scene_.materials.push_back(file.cloth_looks.at(c).material);
            scene_.uv.middleRows(cloth.first_vertex, cloth.vertex_count) = texture_points(
                scene_.topology.rest_positions.middleRows(cloth.first_vertex, cloth.vertex_count),
                scene_.triangles_of(cloth), scene_.materials.back());
        }
        for (std::size_t c = 0; c < file.scene.colliders.size(); ++c) {
            const ColliderDesc& collider = file.scene.colliders[c];
            if (!collider.drawn) continue;
            colliders_.push_back(c);
            scene_.colliders.push_back({one_line(collider.name), make_shape(collider)->surface(),
                                        file.collider_looks.at(c).material, collider.cache != nullptr});
        }
        scene_.frame_rate = file.scene.simulation.frame_rate;
        scene_.aspect = static_cast<double>(file.view.width) / file.view.height;
        scene_.frames = chosen_frames(run_.folder, choice.frames);
        scene_.fields = vertex_field_names();
        camera_ = file.camera;
        if (camera_.framing == Framing::automatic) {
            if (const auto extent = survey_run(run_.folder, file, run_.model, stop).extent)
                camera_ = extent->framed(camera_);
        }
    }

    const ExportScene& scene() const { return scene_; }
    /// Every `every`th of the frames alone.
    void thin_out(int every) {
        std::vector<std::int64_t> kept;
        for (std::size_t k = 0; k < scene_.frames.size(); k += static_cast<std::size_t>(every))
            kept.push_back(scene_.frames[k]);
        scene_.frames = std::move(kept);
    }
    StateReader reader() const { return state_reader(run_.folder, run_.model); }

    ExportFrame frame_of(std::int64_t index, const State& state) const {
        const Eigen::Index n = scene_.vertex_count();
        const auto own = [&](const VecX& all) {
            return Points(Eigen::Map<const Points>(all.data() + 3 * first_, n, 3));
        };
        ExportFrame frame{.index = index,
                          .time = scene_.time(index),
                          .positions = own(state.positions),
                          .velocities = own(state.velocities),
                          .colliders = {},
                          .camera = {},
                          .field = [this, &state, n](VertexField field) -> VecX {
                              return fields_.at(field, state).segment(first_, n);
                          }};
        for (const std::size_t c : colliders_) {
            const ColliderDesc& collider = run_.model.scene.colliders[c];
            ColliderPose pose{state.collider_on[c] != 0, placement_at(collider, state.time)};
            if (pose.placement.bent) pose.bent = make_shape(collider, pose.placement)->surface();
            frame.colliders.push_back(std::move(pose));
        }
        const CameraPose pose = camera_at(camera_, state.time);
        frame.camera = {pose.position, pose.target, camera_.up, pose.field_of_view};
        return frame;
    }

  private:
    KeptRun run_;
    Topology topology_;
    VertexFields fields_;
    ExportScene scene_;
    int first_ = 0;                       ///< vertex of those that are exported
    std::vector<std::size_t> colliders_;  ///< those that are exported
    CameraDesc camera_;
};

/// All frames of a run to an exporter.
void pass_on(const ExportedRun& run, Exporter& exporter, const RunOptions& options) {
    const StateReader read = run.reader();
    Progress progress{.frames = static_cast<std::int64_t>(run.scene().frames.size())};
    exporter.begin(run.scene());
    for (const std::int64_t frame : run.scene().frames) {
        if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: no mesh was written");
        const State state = read_kept(read, frame);
        exporter.frame(run.frame_of(frame, state));
        ++progress.simulated;
        if (options.progress) options.progress(progress);
    }
    exporter.end();
}

}  // namespace

std::vector<std::int64_t> export_frames(const fs::path& out, const ExportChoice& choice,
                                        const ExportFormat& format, const fs::path& file, FrameNames names,
                                        const RunOptions& options) {
    std::error_code ignored;
    if (!file.has_filename() || fs::is_directory(file, ignored))
        throw Error(ExitCode::usage,
                    fmt::format("--file {}: is a folder; give a name in it, as in {}", file.string(),
                                (file / fmt::format("sheet{}", format.extension())).string()));
    const ExportedRun run(out, choice, options.stop);
    pass_on(run, *format.make(file, names), options);
    return run.scene().frames;
}

void record_frames(const fs::path& out, int every, Exporter& exporter, const RunOptions& options) {
    ExportedRun run(out, {}, options.stop);
    run.thin_out(every);
    RunOptions quiet = options;
    quiet.progress = nullptr;
    pass_on(run, exporter, quiet);
}

}  // namespace cloth::pipeline
