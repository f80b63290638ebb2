// Kept states as meshes: what an exporter is told, and what is refused.

#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/formats/state_store.h"
#include "pipeline/run/run.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Four kept frames of a small sheet that rises by 1 m a frame, at 25 frames per second.
class Kept {
  public:
    Kept() {
        const SceneFile file =
            parse_scene("version = 1\n[simulation]\nframe_rate = 25\n[[cloth]]\nresolution = [3, 4]\n",
                        "s.toml", folder_.path());
        const Model model = build_model(file.scene);
        const RunFolder run = start_run(out(), {file, model, 4}, {}).folder;
        State state = start_state(model);
        for (state.frame = 0; state.frame < 4; ++state.frame) {
            write_state(state, run.state(state.frame));
            for (Eigen::Index i = 1; i < state.positions.size(); i += 3) state.positions[i] += 1.0;
        }
    }
    fs::path out() const { return folder_ / "run"; }
    fs::path operator/(const std::string& name) const { return folder_ / name; }

  private:
    TemporaryFolder folder_;
};

/// What a format of one file for all frames was told.
std::vector<std::string> told;

class Listener : public Exporter {
  public:
    explicit Listener(const fs::path& file) { told = {file.filename().string()}; }
    void begin(const ExportScene& scene) override {
        const Topology& topology = scene.topology;
        told.push_back("begin " + std::to_string(topology.rest_positions.rows()) + " vertices, " +
                       std::to_string(topology.triangles.rows()) + " triangles, " +
                       std::to_string(static_cast<int>(scene.frame_rate)) + "/s");
        start_ = topology.rest_positions(0, 1);
    }
    void frame(const ExportFrame& frame) override {
        CHECK(frame.positions.rows() == 12);
        told.push_back("frame " + std::to_string(frame.index) + " at " + std::to_string(frame.time) +
                       ", risen by " + std::to_string(frame.positions(0, 1) - start_));
    }
    void end() override { told.emplace_back("end"); }

  private:
    double start_ = 0.0;
};

const ExportFormat listening{"listening",
                             {".ear"},
                             "for this test",
                             SequenceFiles::one,
                             [](const fs::path& file, FrameNames) -> std::unique_ptr<Exporter> {
                                 return std::make_unique<Listener>(file);
                             }};

}  // namespace

TEST_CASE("an exporter is told topology, rate, and each frame with its time", "[export]") {
    const Kept kept;
    export_frames(kept.out(), {FrameSpan{1, 3}}, listening, kept / "all.ear", FrameNames::numbered, {});
    CHECK(told == std::vector<std::string>{"all.ear", "begin 12 vertices, 12 triangles, 25/s",
                                           "frame 1 at 0.040000, risen by 1.000000",
                                           "frame 2 at 0.080000, risen by 2.000000", "end"});
    export_frames(kept.out(), {FrameSpan{3, 4}}, listening, kept / "one.ear", FrameNames::as_given, {});
    CHECK(told == std::vector<std::string>{"one.ear", "begin 12 vertices, 12 triangles, 25/s",
                                           "frame 3 at 0.120000, risen by 3.000000", "end"});
}

TEST_CASE("progress of an export is told frame by frame, and one that is stopped leaves nothing",
          "[export]") {
    const Kept kept;
    std::atomic<bool> stop = false;
    std::vector<std::int64_t> done;
    RunOptions options;
    options.stop = &stop;
    options.progress = [&](const Progress& progress) {
        CHECK(progress.frames == 4);
        done.push_back(progress.simulated);
        stop = progress.simulated == 2;
    };
    const ExportFormat& obj = export_format("obj", "");
    CHECK(
        message_of([&] { export_frames(kept.out(), {}, obj, kept / "m.obj", FrameNames::numbered, options); },
                   ExitCode::interrupted) == "interrupted: no mesh was written");
    CHECK(done == std::vector<std::int64_t>{1, 2});
    CHECK(std::distance(fs::directory_iterator(kept / ""), {}) == 1);  // the run itself
}

TEST_CASE("a sequence that cannot be made is refused, and nothing is left of it", "[export]") {
    const Kept kept;
    const ExportFormat& ply = export_format("ply", "");
    const auto refusal = [&](const FrameSpan& span, const std::string& file, ExitCode code) {
        const std::string message = message_of(
            [&] { export_frames(kept.out(), {span}, ply, kept / file, FrameNames::numbered, {}); }, code);
        CHECK(std::distance(fs::directory_iterator(kept / ""), {}) == 1);
        return message;
    };
    const std::string run = kept.out().string();
    CHECK(refusal({2, 5}, "m.ply", ExitCode::usage) ==
          "--frames 2:5: the state of frame 4 is not kept in " + run + "; kept: 4 frames from 0 to 3");
    CHECK(refusal({0, 2}, "", ExitCode::usage) == "--file " + (kept / "").string() +
                                                      ": is a folder; give a name in it, as in " +
                                                      (kept / "sheet.ply").string());
    CHECK(refusal({0, 2}, "run", ExitCode::usage) ==
          "--file " + run + ": is a folder; give a name in it, as in " + run + "/sheet.ply");
    CHECK_THAT(refusal({0, 2}, "none/m.ply", ExitCode::other),
               Contains("cannot write ") && Contains("none/m_000000.ply: No such file or directory"));
    spit(kept / "run/states/state_000002.bin", "no state");
    CHECK_THAT(refusal({0, 4}, "m.ply", ExitCode::other), Contains("state_000002.bin"));
    for (int frame = 0; frame < 4; ++frame) fs::remove(RunFolder::open(kept.out()).state(frame));
    CHECK(refusal({0, 4}, "m.ply", ExitCode::other) == run + ": keeps no states");
}
