#pragma once
// Pictures → MP4 by the FFmpeg command line.

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>

#include "render/image/image.h"

namespace cloth::pipeline {

struct VideoOptions {
    double frame_rate = 60.0;  ///< [1/s]
    int quality = 18;          ///< constant rate factor
    int threads = 0;           ///< ≤ 0: all cores
    /// Looked at while FFmpeg is waited for: true ends it, with Error(interrupted) and no file.
    const std::atomic<bool>* stop = nullptr;
};

/// FFmpeg's version line; throws Error(encoder) where it is missing. `stop` as in VideoOptions.
std::string ffmpeg_version(const std::atomic<bool>* stop = nullptr);

/// H.264, yuv420p, bt709 tagged, fast start; odd sizes are padded to even by repeating the edge. The frames
/// are piped as raw pixels while they are made. The movie appears under its name only when finish()
/// succeeded. FFmpeg does not outlive the thread that made this.
class VideoWriter {
  public:
    VideoWriter(const std::filesystem::path& path, int width, int height, const VideoOptions& options);
    ~VideoWriter();  ///< without finish(): removes the unfinished file
    void add(const render::Image& image);
    /// Reads the movie back and counts its frames. Throws Error(encoder) with FFmpeg's own last words, or
    /// where a frame is missing.
    void finish();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth::pipeline
