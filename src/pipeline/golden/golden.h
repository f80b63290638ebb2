#pragma once
// Golden states and pictures: compare, bless, the report of a mismatch.
//
// golden/<scene>/ holds state_000000.bin, frame_000000.png … and golden.json (build fingerprint, renderer,
// tolerances). States are compared first; pictures are drawn from the *golden* states, so that a change of
// the simulation and one of the renderer are told apart.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/run/run_options.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/gl/gl_library.h"
#include "render/image/image.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

struct StateGate {
    bool exact = false;       ///< same build: every bit must agree
    double tolerance = 1e-6;  ///< otherwise: every vertex must be nearer than this [m]
};
struct StateVerdict {
    bool passed = false;
    double largest_distance = 0;  ///< [m]
    int worst_vertex = -1;
    std::string reason;  ///< empty when passed
};
/// Compares positions; exactly also velocities.
StateVerdict judge_state(const State& golden, const State& actual, const StateGate& gate);

struct ImageVerdict {
    bool passed = false;
    render::ImageDifference difference;
    std::string reason;
};
/// `exact`: decoded pixels equal (same renderer and version). Otherwise off by more than 2 at most 0.05 % of
/// the pixels, by more than 32 at most 0.01 %, and a PSNR of at least 57 dB: passes the noise between
/// processors, fails a missing shadow or a moved fold.
ImageVerdict judge_image(const render::Image& golden, const render::Image& actual, bool exact);

/// Size of golden pictures, whatever the scene's own [pixel].
inline constexpr int golden_width = 480, golden_height = 270;

struct GoldenRow {
    std::int64_t frame = 0;
    StateVerdict state;
    ImageVerdict image;
};
struct GoldenResult {
    std::string scene;
    bool passed = false;
    double state_tolerance = 0;  ///< [m]
    std::string golden_build, actual_build, golden_renderer, actual_renderer;
    std::vector<GoldenRow> rows;
    std::filesystem::path report;  ///< self-contained HTML page
};

/// The rows as text, one a line under a heading; the last line is the verdict.
std::string golden_table(const GoldenResult& result);

/// Re-runs the scene and compares with the goldens in the folder `golden`; writes the page `out`/golden.html.
/// Throws Error(golden_mismatch) where goldens are missing, naming the command that makes them.
GoldenResult compare_golden(const SceneFile& file, const std::filesystem::path& golden,
                            const std::filesystem::path& out, int threads,
                            render::GlLibrary gl = render::GlLibrary::automatic);
/// Compares the states that a run keeps with the goldens in the folder of its scene in `goldens`; its page
/// report.html shows them beside the run. Throws Error(golden_mismatch) where goldens are missing, or no
/// golden frame is kept; as write_run_page().
GoldenResult compare_kept_run(const std::filesystem::path& run, const std::filesystem::path& goldens,
                              const RunOptions& options);
/// Re-runs the scene and replaces its goldens; returns the comparison with what stood there before (no rows
/// where nothing did). Only files of goldens are replaced or removed.
GoldenResult bless_golden(const SceneFile& file, const std::filesystem::path& golden,
                          const std::filesystem::path& out, int threads,
                          render::GlLibrary gl = render::GlLibrary::automatic);

}  // namespace cloth::pipeline
