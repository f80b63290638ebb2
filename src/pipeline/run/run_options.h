#pragma once
// How a run is made.

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "base/whole_file.h"
#include "render/gl/gl_library.h"

namespace cloth::pipeline {

/// Frames that each stage has finished.
struct Progress {
    std::int64_t frames = 0;  ///< to be made
    std::int64_t simulated = 0, drawn = 0, written = 0, encoded = 0;
};

struct RunOptions {
    bool pictures = true;
    bool page = true;                                     ///< report.html is left (run_page.h)
    bool movie = true;                                    ///< needs pictures
    int threads = 0;                                      ///< ≤ 0: all cores
    render::GlLibrary gl = render::GlLibrary::automatic;  ///< what draws
    /// Called after each frame of each stage, by one thread at a time.
    std::function<void(const Progress&)> progress;
    Sync sync = Sync::yes;  ///< of each state; no: the caller sees to it that the disk gets them
    bool fresh = false;     ///< nothing that is kept is used again
    /// Told what a user is to know before it happens: what is damaged, what finished things are replaced.
    std::function<void(const std::string& line)> tell;
    /// Looked at between frames, within steps, and while FFmpeg is waited for: true ends the run, every
    /// finished frame kept.
    const std::atomic<bool>* stop = nullptr;

    bool stopping() const { return stop != nullptr && stop->load(); }
};

}  // namespace cloth::pipeline
