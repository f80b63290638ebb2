#pragma once
// Simulate, draw, write PNGs, encode: stages that work at the same time on successive frames. What they make
// does not depend on how they interleave. Each gives back what it did; nothing is written by two of them.
// Internal to this room.

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include <tbb/concurrent_queue.h>

#include "base/stopwatch.h"
#include "pipeline/formats/video.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/run_options.h"
#include "render/image/image.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

/// What each stage did, with the time that it was busy [s].
struct StatesMade {
    std::vector<FrameRecord> records;  ///< of the states that were simulated and written, and of
    std::int64_t kept = 0;             ///< those that were there
    double simulate = 0, store = 0;
};
struct PicturesDrawn {
    std::int64_t kept = 0;  ///< that were there
    double seconds = 0;
};
struct PicturesWritten {
    std::int64_t images = 0;
    double seconds = 0;
};
struct MovieEncoded {
    bool finished = false;  ///< with a picture of each frame
    double seconds = 0;
};
struct StagesResult {
    StatesMade states;
    PicturesDrawn drawn;
    PicturesWritten written;
    MovieEncoded encoded;
    double wall = 0;             ///< [s]
    std::exception_ptr failure;  ///< that the caller is to throw; none: empty
};

/// Adds what stages made to the run's, one after the other where they ran more than once.
void add(RunSummary& summary, const StagesResult& result, const RunFolder& folder);

/// Pictures that are there and need not be drawn, and who is told of new ones.
struct KeptPictures {
    std::function<bool(std::int64_t frame)> has;
    /// Once it has its name; `draw`, `png`: time that it took [s].
    std::function<void(std::int64_t frame, double draw, double png)> written;
};

class Stages {
  public:
    using Produce = std::function<void(Stages&, StatesMade&)>;
    using Draw = std::function<render::Image(const State&)>;

    /// `frames`: to be made.
    Stages(const RunFolder& folder, const RunOptions& options, std::int64_t frames);

    /// `produce` delivers states in order of frames; `draw` may be empty: then that is all. The caller's
    /// thread draws (a GL context belongs to one thread); one thread each produces, writes PNGs, and feeds
    /// the `movie`, if any.
    StagesResult run(const Produce& produce, const Draw& draw, VideoWriter* movie,
                     const KeptPictures& kept = {});

    // ---- for `produce`
    /// False: the caller wants to stop, or something failed after which nothing more is worth doing.
    bool going_on() const;
    /// Hands a state to the stage that draws, which may be some frames behind.
    void deliver(std::shared_ptr<const State> state);
    /// In its place, where has_picture(): the picture that is there.
    void deliver_kept(std::int64_t frame);
    /// Whether the picture of a frame is there.
    bool has_picture(std::int64_t frame) const { return !drawing_ || (kept_.has && kept_.has(frame)); }
    void step(std::int64_t Progress::*stage);
    /// A failure that lets the other stages finish. What is thrown lets no one.
    void fail_later(std::exception_ptr failure);

  private:
    struct Delivered {
        std::int64_t frame = -1;             ///< -1: the last has been
        std::shared_ptr<const State> state;  ///< null: its picture is there
    };
    struct Picture {
        std::int64_t frame = 0;
        std::shared_ptr<const render::Image> image;
        double seconds = 0;  ///< that drawing took
    };
    /// A fast stage waits for a slow one instead of filling the memory. An empty entry is the last; whoever
    /// takes from a queue does so up to there, whatever fails, and so nobody waits for ever to put something
    /// in.
    template <class T>
    using Queue = tbb::concurrent_bounded_queue<T>;

    template <class Work>
    void guarded(Work work);
    void fail_now(std::exception_ptr failure);
    StatesMade produce_states(const Produce& produce);
    PicturesDrawn draw_states(const Draw& draw, bool to_movie);
    PicturesWritten write_pictures();
    MovieEncoded feed(VideoWriter& movie);

    const RunFolder& folder_;
    const RunOptions& options_;
    std::int64_t frames_;
    std::mutex progress_mutex_, failure_mutex_;
    Progress progress_;
    std::exception_ptr failure_, late_failure_;
    std::atomic<bool> failed_ = false;
    bool drawing_ = false;
    KeptPictures kept_;
    Queue<Delivered> states_;
    Queue<Picture> to_png_, to_movie_;
};

}  // namespace cloth::pipeline
