// States on disk: exact, guarded, and never half-written.

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

State example_state() {
    State state;
    state.step = 1234567890123;
    state.frame = 7;
    state.time = 0.1;
    state.positions = VecX::LinSpaced(30, -1.0, 2.0).array().sin();
    state.velocities = VecX::LinSpaced(30, 3.0, 4.0).array().exp();
    state.positions[0] = -0.0;
    state.positions[1] = std::numeric_limits<double>::denorm_min();
    state.velocities[2] = 1.0 / 3.0;
    state.integrator = IntegratorKind::implicit_euler;
    state.collider_on = {1, 0, 1};
    state.drags.resize(2);
    state.drags[1] = {true, {3, 5}, {Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3)}, Vec3(9, 8, 7)};
    state.events_done = 4;
    return state;
}

bool same_bits(const VecX& a, const VecX& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * std::size_t(a.size())) == 0;
}

}  // namespace

TEST_CASE("a state comes back from disk bit by bit", "[state_store]") {
    const TemporaryFolder folder;
    const State state = example_state();
    for (const Compression compression : {Compression::fast, Compression::small}) {
        write_state(state, folder / "s.bin", compression);
        const State back = read_state(folder / "s.bin");
        CHECK(back.step == state.step);
        CHECK(back.frame == state.frame);
        CHECK(back.time == state.time);
        CHECK(same_bits(back.positions, state.positions));
        CHECK(same_bits(back.velocities, state.velocities));
        CHECK(back.integrator == state.integrator);
        CHECK(back.collider_on == state.collider_on);
        REQUIRE(back.drags.size() == 2);
        CHECK_FALSE(back.drags[0].pressed);
        CHECK(back.drags[1].pressed);
        CHECK(back.drags[1].vertices == state.drags[1].vertices);
        REQUIRE(back.drags[1].anchors.size() == 2);
        CHECK(back.drags[1].anchors[1] == state.drags[1].anchors[1]);
        CHECK(back.drags[1].grabbed == state.drags[1].grabbed);
        CHECK(back.events_done == state.events_done);
        CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    }
}

TEST_CASE("a state of NaNs comes back too: it shows what went wrong", "[state_store]") {
    const TemporaryFolder folder;
    State state = example_state();
    state.positions[5] = std::numeric_limits<double>::quiet_NaN();
    state.velocities[6] = std::numeric_limits<double>::infinity();
    write_state(state, folder / "s.bin");
    CHECK(same_bits(read_state(folder / "s.bin").positions, state.positions));
    CHECK(same_bits(read_state(folder / "s.bin").velocities, state.velocities));
}

TEST_CASE("every damaged byte and every cut of a state file is noticed, and the file named",
          "[state_store]") {
    const TemporaryFolder folder;
    write_state(example_state(), folder / "s.bin");
    const std::string good = slurp(folder / "s.bin");
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::string bad = good;
        bad[i] = static_cast<char>(bad[i] ^ 0x10);
        spit(folder / "bad.bin", bad);
        INFO("byte " << i);
        CHECK_THAT(message_of([&] { read_state(folder / "bad.bin"); }, ExitCode::other),
                   Contains("bad.bin: "));
    }
    for (std::size_t size = 0; size < good.size(); size += 7) {
        spit(folder / "bad.bin", good.substr(0, size));
        CHECK_THAT(message_of([&] { read_state(folder / "bad.bin"); }, ExitCode::other),
                   Contains("cut short"));
    }
    CHECK_THAT(message_of([&] { read_state(folder / "none.bin"); }, ExitCode::other),
               Contains("cannot read") && Contains("none.bin") && Contains("No such file"));
    spit(folder / "text.bin", "hello, I am a text file, not a state");
    CHECK_THAT(message_of([&] { read_state(folder / "text.bin"); }, ExitCode::other),
               Contains("not a file of kind"));
}

TEST_CASE("the hash of a state sees the last bit of any position and velocity", "[state_store]") {
    const State state = example_state();
    const std::string hash = state_hash(state);
    CHECK(hash.size() == 16);
    CHECK(state_hash(example_state()) == hash);
    for (VecX State::*vector : {&State::positions, &State::velocities}) {
        State other = state;
        (other.*vector)[17] = std::nextafter((other.*vector)[17], 10.0);
        CHECK(state_hash(other) != hash);
    }
}

TEST_CASE("a full disk leaves the old file whole and no half-written one", "[state_store]") {
    const TemporaryFolder folder;
    spit(folder / "s.bin", "old");
    // A limit on file size stands in for a full disk: the write fails part-way.
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{100, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    std::string message;
    try {
        write_state(example_state(), folder / "s.bin");
    } catch (const Error& e) {
        message = e.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, old_handler);
    CHECK_THAT(message, Contains("cannot write") && Contains("s.bin") && Contains("File too large"));
    CHECK(slurp(folder / "s.bin") == "old");
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("the topology of a run comes back and is compared with a model", "[state_store]") {
    const TemporaryFolder folder;
    Scene scene;
    scene.cloths.resize(2);
    scene.cloths[0].grid.resolution = {3, 4};
    scene.cloths[1].grid.resolution = {2, 2};
    scene.cloths[1].name = "second";
    scene.simulation.substeps = 1;
    const Model model = build_model(scene);
    write_topology(model, folder / "t.bin");
    const Topology topology = read_topology(folder / "t.bin");
    CHECK(topology.rest_positions == model.rest_positions);
    CHECK(topology.triangles == model.triangles);
    REQUIRE(topology.cloths.size() == 2);
    CHECK(topology.cloths[1].name == "second");
    CHECK(topology.cloths[1].first_vertex == 12);
    CHECK(topology.cloths[1].triangle_count == 2);
    CHECK(same_topology(topology, model));
    scene.cloths[0].grid.diagonals = Diagonals::alternating;
    CHECK_FALSE(same_topology(topology, build_model(scene)));
}

TEST_CASE("the build fingerprint names all that decides a state's bits", "[state_store]") {
    CHECK_THAT(build_fingerprint(), (Contains("g++ ") || Contains("clang ")) && Contains(" -O") &&
                                        Contains("Eigen 3.") && Contains("state format"));
}
