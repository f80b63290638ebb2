#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/page/page.h"
#include "pipeline/run/run_page.h"
#include "pipeline/run/shown_run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr PageMeasure farthest_measure = {
    "apart_m", "Greatest distance between the runs", "m", true, "most", "farthest apart"};
constexpr PageMeasure rms_measure = {"apart_rms_m", "Root mean square of the distances", "m", true};

bool same_bits(const VecX& a, const VecX& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// Of each vertex from itself [m].
VecX distances(const VecX& a, const VecX& b) {
    VecX result(a.size() / 3);
    for (Eigen::Index v = 0; v < result.size(); ++v)
        result(v) = (a.segment<3>(3 * v) - b.segment<3>(3 * v)).norm();
    return result;
}

FrameDistance distance_of(const Model& model, const State& a, const State& b) {
    const VecX apart = distances(a.positions, b.positions);
    FrameDistance distance{
        a.frame, 0, std::sqrt(apart.squaredNorm() / static_cast<double>(apart.size())), {}};
    Eigen::Index worst = 0;
    distance.largest = apart.maxCoeff(&worst);
    for (const ClothRange& cloth : model.cloths)
        if (worst >= cloth.first_vertex && worst < cloth.first_vertex + cloth.vertex_count)
            distance.vertex = fmt::format("vertex {} of cloth {}", worst - cloth.first_vertex, cloth.name);
    return distance;
}

/// The states of two runs, frame by frame.
class Pair {
  public:
    Pair(const fs::path& a, const fs::path& b)
        : a_(open_run(a)),
          b_(open_run(b)),
          read_a_(state_reader(a_.folder, a_.model)),
          read_b_(state_reader(b_.folder, b_.model)) {}

    std::string incomparable() const {
        const auto differ = [](auto x, auto y, const char* what) {
            return x == y ? std::string() : fmt::format("{} {} against {}", x, what, y);
        };
        const std::string vertices = differ(a_.model.vertex_count(), b_.model.vertex_count(), "vertices");
        return !vertices.empty() ? vertices
                                 : differ(a_.file.scene.simulation.frame_rate,
                                          b_.file.scene.simulation.frame_rate, "frames per second");
    }

    /// Frames that both keep, and how far apart they are there, as columns of run `a`'s.
    RunDifference compare(const RunOptions& options, Json& columns) const {
        RunDifference difference;
        difference.incomparable = incomparable();
        Json farthest = Json::array(), rms = Json::array();
        for (const std::int64_t frame : a_.folder.kept_states()) {
            if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: no page was written");
            const auto both = difference.incomparable.empty() ? states(frame) : std::nullopt;
            farthest.push_back(nullptr);
            rms.push_back(nullptr);
            if (!both) continue;
            ++difference.common;
            const auto& [a, b] = *both;
            const FrameDistance distance = distance_of(a_.model, a, b);
            farthest.back() = distance.largest;
            rms.back() = distance.rms;
            if (!difference.first &&
                !(same_bits(a.positions, b.positions) && same_bits(a.velocities, b.velocities)))
                difference.first = distance;
            if (distance.largest > difference.farthest.largest) difference.farthest = distance;
        }
        if (difference.common > 0) {
            columns[farthest_measure.key] = std::move(farthest);
            columns[rms_measure.key] = std::move(rms);
        }
        return difference;
    }

    /// How far the vertices are from those of the other run, as colours.
    ViewField field(const RunDifference& difference) const {
        const double high = std::max(difference.farthest.largest, 1e-12);
        return {"apart",
                "distance between the runs",
                "m",
                [this](const ExportFrame& frame) -> VecX {
                    if (const auto both = states(frame.index))
                        return distances(both->first.positions, both->second.positions);
                    return VecX::Constant(frame.positions.rows(), std::numeric_limits<double>::quiet_NaN());
                },
                [high](const std::vector<double>&, double) {
                    return ShadeRange{1e-4 * high, high, true, false};
                },
                /*log=*/true};
    }

  private:
    std::optional<std::pair<State, State>> states(std::int64_t frame) const {
        std::optional<State> a = read_a_(frame), b = read_b_(frame);
        if (!a || !b) return std::nullopt;
        return std::pair(std::move(*a), std::move(*b));
    }

    KeptRun a_, b_;
    StateReader read_a_, read_b_;
};

Json lines(const RunDifference& d) {
    if (!d.incomparable.empty())
        return Json::array(
            {fmt::format("Their states cannot be compared: {}. Their measures can.", d.incomparable)});
    if (d.common == 0) return Json::array({"They keep no frame in common."});
    const std::string common = plural(d.common, "common frame");
    if (!d.first)
        return Json::array({fmt::format("Their states are the same to the bit in all of {}.", common)});
    const FrameDistance &first = *d.first, &far = d.farthest;
    Json all = Json::array();
    all.push_back(fmt::format(
        "They part in frame {}: the first of {} whose states differ in a bit, {}.", first.frame, common,
        first.largest > 0 ? fmt::format("farthest {} by {:.3g} m", first.vertex, first.largest)
                          : "of velocities alone"));
    if (far.largest > 0)
        all.push_back(
            fmt::format("Farthest apart is {} in frame {}: {:.3g} m, all vertices {:.3g} m in the "
                        "root mean square.",
                        far.vertex, far.frame, far.largest, far.rms));
    return all;
}

}  // namespace

RunDifference write_comparison_page(const fs::path& a, const fs::path& b, const fs::path& file,
                                    const RunOptions& options) {
    std::error_code ignored;
    if (fs::exists(file, ignored) && read_file(file).find(own_mark) == std::string::npos)
        throw Error(ExitCode::usage,
                    fmt::format("--file {}: is there and no page of this program's; give another name",
                                file.string()));
    const std::string label_a = a.string(), label_b = b.string();
    const Pair pair(a, b);
    Json columns = Json::object();
    const RunDifference difference = pair.compare(options, columns);
    std::optional<ViewField> apart;
    if (difference.first) apart = pair.field(difference);
    ShownRun run_a = shown_run(a, {label_a, file, 2, apart}, options);
    const ShownRun run_b = shown_run(b, {label_b, file, 2, apart}, options);
    run_a.run["frames"].update(columns);
    Json data;
    data["mark"] = own_mark;
    data["title"] = fmt::format("{} and {}", label_a, label_b);
    data["verdict"] =
        difference.same() ? Json{{"text", "the same"}, {"tone", "good"}}
        : difference.first
            ? Json{{"text", fmt::format("they part in frame {}", difference.first->frame)}, {"tone", "warn"}}
            : Json{{"text", "not comparable"}, {"tone", "warn"}};
    data["lines"] = lines(difference);
    if (const auto keys = differences(run_a.file, run_b.file); !keys.empty())
        data["lines"].push_back("Keys of their scenes that differ: " + join(keys) + ".");
    data["faults"] = Json::array();
    add_fault(data, run_a, label_a + ": ");
    add_fault(data, run_b, label_b + ": ");
    data["measures"] = Json::array();
    if (difference.common > 0) data["measures"] = {measure_json(farthest_measure), measure_json(rms_measure)};
    for (const Json& measure : frame_measures()) data["measures"].push_back(measure);
    if (difference.first)
        data["links"] = Json::array({{{"text", "they part"}, {"frame", difference.first->frame}}});
    data["facts_head"] = {"", label_a, label_b};
    data["facts"] = facts_of({&run_a, &run_b});
    data["runs"] = Json::array({run_a.run, run_b.run});
    write_file(file, page_text(data));
    return difference;
}

}  // namespace cloth::pipeline
