#pragma once
// Work that takes a while: its flags, its progress on standard error, Ctrl-C, and its last line.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "apps/cli/command_line.h"
#include "apps/cli/scene_flags.h"
#include "apps/cli/signals.h"
#include "pipeline/run/run.h"

namespace cloth::cli {

/// How the work is done; none of it changes a result.
struct WorkFlags {
    int threads = 0;  ///< 0: all cores
    std::string gl = "auto";
    bool quiet = false, no_video = false;
    bool json = false;              ///< the result as JSON
    std::string progress = "text";  ///< "json": what happens as objects, one a line
    bool fresh = false, explain = false;

    void add_threads(Flags& flags);
    void add_gl(Flags& flags);
    /// Both, and --quiet, --no-video, --json and --progress.
    void add(Flags& flags);
    void add_reuse(Flags& flags);  ///< --fresh and --explain

    render::GlLibrary gl_library() const;
};

/// "4:05", "1:00:07".
std::string clock_text(double seconds);

/// What a first Ctrl-C does.
enum class OnSignal {
    end,     ///< the program ends: what is half made is worth nothing
    finish,  ///< the work is asked to stop and keeps what it has (StopRequest)
};

/// While it lives, progress is shown, and signals are heeded.
class Watch {
  public:
    Watch(const WorkFlags& flags, bool pictures, OnSignal on_signal);
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    const pipeline::RunOptions& options() const { return options_; }

  private:
    std::unique_ptr<class ProgressLine> line_;
    std::optional<StopRequest> request_;
    pipeline::RunOptions options_;
};

/// Tells in a line, or as JSON, what a run made and how long each stage took. Throws Error(interrupted) where
/// it was stopped, saying what is kept and which command makes a movie of it.
void conclude(const pipeline::RunSummary& summary, const std::filesystem::path& out, const WorkFlags& flags);

/// Simulates the scene that is asked for, draws it where `pictures` are wanted, and concludes. Gives the
/// run's folder.
std::filesystem::path run_scene(const SceneFlags& scene, const WorkFlags& flags, bool pictures);

}  // namespace cloth::cli
