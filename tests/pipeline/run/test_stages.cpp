// The stages of a run: all frames pass them in order, and whatever fails, they come to an end.

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>

#include "pipeline/run/stages.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t frames = 40;  // far more than wait between two stages

render::Image plain(const State& state) {
    render::Image image{16, 16, std::vector<std::uint8_t>(std::size_t{4} * 16 * 16, 255)};
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        image.rgba[i] = static_cast<std::uint8_t>(state.frame);
    return image;
}

/// Delivers frames as long as they are wanted, and records each.
void produce(Stages& stages, StatesMade& made) {
    for (std::int64_t frame = 0; frame < frames && stages.going_on(); ++frame) {
        auto state = std::make_shared<State>();
        state->frame = frame;
        made.records.emplace_back();
        stages.step(&Progress::simulated);
        stages.deliver(std::move(state));
    }
}

std::string message_of(const std::exception_ptr& failure) {
    if (!failure) return "";
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& e) {
        return e.what();
    }
}

struct Fixture {
    TemporaryFolder place;
    RunFolder folder = RunFolder::create(place.path());
    RunOptions options;
    Progress last;
    Fixture() {
        options.progress = [this](const Progress& progress) { last = progress; };
    }
    std::size_t pictures() const { return folder.kept_images().size(); }
};

}  // namespace

TEST_CASE_METHOD(Fixture, "every state becomes its picture", "[stages]") {
    const StagesResult result = Stages(folder, options, frames).run(produce, plain, nullptr);
    CHECK_FALSE(result.failure);
    CHECK(result.states.records.size() == frames);
    CHECK(result.written.images == frames);
    REQUIRE(pictures() == frames);
    CHECK(last.simulated == frames);
    CHECK(last.drawn == frames);
    CHECK(last.written == frames);
    for (const std::int64_t frame : {0, 17, 39})
        CHECK(render::read_png(folder.image(frame)).rgba[0] == static_cast<std::uint8_t>(frame));
    CHECK(result.drawn.seconds > 0.0);
    CHECK(result.written.seconds > 0.0);
    CHECK(result.wall > 0.0);

    RunSummary summary;
    add(summary, result, folder);
    add(summary, result, folder);
    CHECK(summary.states == 2 * frames);
    CHECK(summary.images == 2 * frames);
    CHECK(summary.times.wall == 2 * result.wall);
    CHECK(summary.movie.empty());
}

TEST_CASE_METHOD(Fixture, "without pictures the states are produced and nothing else", "[stages]") {
    const StagesResult result = Stages(folder, options, frames).run(produce, {}, nullptr);
    CHECK_FALSE(result.failure);
    CHECK(result.states.records.size() == frames);
    CHECK(pictures() == 0);
}

TEST_CASE_METHOD(Fixture, "a picture that cannot be drawn ends the run", "[stages]") {
    const auto draw = [](const State& state) {
        if (state.frame == 5) throw std::runtime_error("no memory for it");
        return plain(state);
    };
    const StagesResult result = Stages(folder, options, frames).run(produce, draw, nullptr);
    CHECK(message_of(result.failure) == "no memory for it");
    CHECK(result.states.records.size() >= 6);
    CHECK(result.states.records.size() < frames);
    CHECK(result.written.images <= 5);
}

TEST_CASE_METHOD(Fixture, "a picture that cannot be written ends the run and keeps what was made",
                 "[stages]") {
    fs::create_directory(folder.image(3));
    const StagesResult result = Stages(folder, options, frames).run(produce, plain, nullptr);
    CHECK(message_of(result.failure) == "cannot write " + folder.image(3).string() + ": Is a directory");
    CHECK(result.written.images == 3);
    CHECK(result.states.records.size() < frames);
}

TEST_CASE_METHOD(Fixture, "what the producer throws ends the run, what it tells of lets the pictures finish",
                 "[stages]") {
    const bool thrown = GENERATE(false, true);
    const auto fail = [&](Stages& stages, StatesMade& made) {
        produce(stages, made);
        const std::runtime_error error("diverged");
        if (thrown) throw error;
        stages.fail_later(std::make_exception_ptr(error));
    };
    const StagesResult result = Stages(folder, options, frames).run(fail, plain, nullptr);
    CHECK(message_of(result.failure) == "diverged");
    CHECK(result.states.records.size() == frames);
    if (!thrown) CHECK(result.written.images == frames);
}

TEST_CASE_METHOD(Fixture, "a movie that fails leaves the pictures to be written", "[stages]") {
    VideoWriter movie(folder.movie("scene"), 32, 32, {});
    const StagesResult result = Stages(folder, options, frames).run(produce, plain, &movie);
    CHECK(message_of(result.failure) == "a picture of 16x16 in a movie of 32x32");
    CHECK_FALSE(result.encoded.finished);
    CHECK(result.written.images == frames);
}

TEST_CASE_METHOD(Fixture, "a movie is finished when it has every frame", "[stages]") {
    const std::int64_t wanted = frames + GENERATE(0, 1);
    VideoWriter movie(folder.movie("scene"), 16, 16, {});
    const StagesResult result = Stages(folder, options, wanted).run(produce, plain, &movie);
    CHECK_FALSE(result.failure);
    CHECK(result.encoded.finished == (wanted == frames));
    CHECK(fs::exists(folder.movie("scene")) == (wanted == frames));
    RunSummary summary;
    summary.scene = "scene";
    add(summary, result, folder);
    CHECK(summary.movie.empty() == (wanted != frames));
}

TEST_CASE_METHOD(Fixture, "a wish to stop ends the run with the pictures drawn so far", "[stages]") {
    std::atomic<bool> stop = false;
    options.stop = &stop;
    const auto draw = [&](const State& state) {
        if (state.frame == 6) stop = true;
        return plain(state);
    };
    const StagesResult result = Stages(folder, options, frames).run(produce, draw, nullptr);
    CHECK_FALSE(result.failure);
    CHECK(result.written.images == 7);
    CHECK(result.states.records.size() < frames);
}
