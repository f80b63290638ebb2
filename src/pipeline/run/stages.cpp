#include "pipeline/run/stages.h"

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "pipeline/formats/error.h"

namespace cloth::pipeline {

void add(RunSummary& summary, const StagesResult& result, const RunFolder& folder) {
    const std::vector<FrameRecord>& records = result.states.records;
    summary.records.insert(summary.records.end(), records.begin(), records.end());
    summary.states += static_cast<std::int64_t>(records.size()) - result.states.kept;
    summary.kept_states += result.states.kept;
    summary.images += result.written.images;
    summary.kept_images += result.drawn.kept;
    if (result.encoded.finished) summary.movie = folder.movie(summary.scene);
    summary.times.simulate += result.states.simulate;
    summary.times.store += result.states.store;
    summary.times.draw += result.drawn.seconds;
    summary.times.png += result.written.seconds;
    summary.times.encode += result.encoded.seconds;
    summary.times.wall += result.wall;
}

Stages::Stages(const RunFolder& folder, const RunOptions& options, std::int64_t frames)
    : folder_(folder), options_(options), frames_(frames) {
    constexpr int capacity = 3;
    states_.set_capacity(capacity);
    to_png_.set_capacity(capacity);
    to_movie_.set_capacity(capacity);
    progress_.frames = frames;
}

StagesResult Stages::run(const Produce& produce, const Draw& draw, VideoWriter* movie,
                         const KeptPictures& kept) {
    const Stopwatch wall;
    StagesResult result;
    drawing_ = static_cast<bool>(draw);
    kept_ = kept;
    std::thread producer, png_writer, encoder;
    try {
        if (draw) png_writer = std::thread([&] { result.written = write_pictures(); });
        if (movie != nullptr) encoder = std::thread([&] { result.encoded = feed(*movie); });
        producer = std::thread([&] { result.states = produce_states(produce); });
        if (draw) result.drawn = draw_states(draw, movie != nullptr);
    } catch (const std::system_error& e) {
        fail_now(std::make_exception_ptr(
            Error(ExitCode::other, std::string("cannot start a thread: ") + e.code().message())));
        if (png_writer.joinable()) to_png_.push({});
        if (encoder.joinable()) to_movie_.push({});
    }
    for (std::thread* thread : {&producer, &png_writer, &encoder}) {
        if (thread->joinable()) thread->join();
    }
    result.wall = wall.seconds();
    result.failure = failure_ ? failure_ : late_failure_;
    return result;
}

bool Stages::going_on() const {
    return !failed_ && !options_.stopping();
}

void Stages::deliver(std::shared_ptr<const State> state) {
    if (!drawing_) return;
    const std::int64_t frame = state->frame;
    states_.push({frame, std::move(state)});
}

void Stages::deliver_kept(std::int64_t frame) {
    if (drawing_) states_.push({frame, nullptr});
}

void Stages::step(std::int64_t Progress::*stage) {
    const std::lock_guard lock(progress_mutex_);
    ++(progress_.*stage);
    if (options_.progress) options_.progress(progress_);
}

void Stages::fail_now(std::exception_ptr failure) {
    const std::lock_guard lock(failure_mutex_);
    if (!failure_) failure_ = std::move(failure);
    failed_ = true;
}

void Stages::fail_later(std::exception_ptr failure) {
    const std::lock_guard lock(failure_mutex_);
    if (!late_failure_) late_failure_ = std::move(failure);
}

template <class Work>
void Stages::guarded(Work work) {
    try {
        work();
    } catch (...) {
        fail_now(std::current_exception());
    }
}

StatesMade Stages::produce_states(const Produce& produce) {
    StatesMade made;
    guarded([&] { produce(*this, made); });
    if (drawing_) states_.push({});
    return made;
}

PicturesDrawn Stages::draw_states(const Draw& draw, bool to_movie) {
    PicturesDrawn drawn;
    Delivered next;
    for (states_.pop(next); next.frame >= 0; states_.pop(next)) {
        if (!going_on()) continue;
        guarded([&] {
            Picture picture{next.frame, nullptr};
            if (!next.state) {
                ++drawn.kept;
                if (to_movie) {
                    picture.image =
                        std::make_shared<const render::Image>(render::read_png(folder_.image(next.frame)));
                    to_movie_.push(picture);
                }
                step(&Progress::drawn);
                step(&Progress::written);
                return;
            }
            {
                const TimedScope watch(picture.seconds);
                picture.image = std::make_shared<const render::Image>(draw(*next.state));
            }
            drawn.seconds += picture.seconds;
            step(&Progress::drawn);
            to_png_.push(picture);
            if (to_movie) to_movie_.push(picture);
        });
    }
    to_png_.push({});
    if (to_movie) to_movie_.push({});
    return drawn;
}

PicturesWritten Stages::write_pictures() {
    PicturesWritten written;
    Picture picture;
    for (to_png_.pop(picture); picture.image; to_png_.pop(picture)) {
        if (failed_) continue;
        guarded([&] {
            double seconds = 0;
            {
                const TimedScope watch(seconds);
                render::write_png(*picture.image, folder_.image(picture.frame));
            }
            written.seconds += seconds;
            if (kept_.written) kept_.written(picture.frame, picture.seconds, seconds);
            ++written.images;
            step(&Progress::written);
        });
    }
    return written;
}

MovieEncoded Stages::feed(VideoWriter& movie) {
    MovieEncoded encoded;
    std::int64_t added = 0;
    bool good = true;
    // The PNGs go on where the encoder fails.
    const auto attempt = [&](auto&& work) {
        const TimedScope watch(encoded.seconds);
        try {
            work();
        } catch (...) {
            good = false;
            if (!options_.stopping()) fail_later(std::current_exception());
        }
    };
    Picture picture;
    for (to_movie_.pop(picture); picture.image; to_movie_.pop(picture)) {
        if (!good || failed_ || options_.stopping()) continue;
        attempt([&] { movie.add(*picture.image); });
        if (!good) continue;
        ++added;
        step(&Progress::encoded);
    }
    // A movie of a part of the run would pass for the whole.
    if (good && added == frames_) {
        attempt([&] { movie.finish(); });
        encoded.finished = good;
    }
    return encoded;
}

}  // namespace cloth::pipeline
