// A folder that somebody edited: states, topology and scenes that are whole by their checksum and say what
// cannot be. Each verb makes something sound of it, or says in a line what is wrong; none crashes.

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A file of the state store around other bytes: magic, checksum, zstd frame.
std::string unpacked(const std::string& file) {
    std::string payload(ZSTD_getFrameContentSize(file.data() + 16, file.size() - 16), '\0');
    REQUIRE(ZSTD_decompress(payload.data(), payload.size(), file.data() + 16, file.size() - 16) ==
            payload.size());
    return payload;
}
std::string packed_body(const std::string& magic, const std::string& body) {
    const std::uint64_t sum = XXH3_64bits(body.data(), body.size());
    return magic + std::string(reinterpret_cast<const char*>(&sum), 8) + body;
}
std::string packed(const std::string& magic, const std::string& payload) {
    std::string body(ZSTD_compressBound(payload.size()), '\0');
    body.resize(ZSTD_compress(body.data(), body.size(), payload.data(), payload.size(), 1));
    return packed_body(magic, body);
}

const char* const verbs[] = {"render --out o --quiet --shade gap --motion-blur 2 --ids 30,20,9",
                             "export --out o --frames 0:3 --file m.obj --quiet",
                             "sheet --out o --quiet --shade stretch"};

/// Exit code 0, or a line that says why not.
void check_sound(const Outcome& outcome) {
    INFO(outcome.err);
    CHECK(outcome.code >= 0);
    CHECK(outcome.code <= 7);
    if (outcome.code == 0) return;
    CHECK_THAT(outcome.err, Catch::StartsWith("render_cloth: "));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    for (const char* foreign :
         {"std::", "bad_alloc", "json", "terminate", "vector", "basic_string", "optional"})
        CHECK_THAT(outcome.err, !Contains(foreign));
}

}  // namespace

TEST_CASE("a kept state that says what cannot be is refused by render, export and sheet alike",
          "[cli][edited]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 3 --no-video").code == 0);
    const fs::path path = place / "o/states/state_000001.bin";
    const State good = pipeline::read_state(path);
    struct Edit {
        const char* what;
        void (*edit)(State&);
    };
    const Edit edits[] = {
        {"is the state of frame 2", [](State& s) { s.frame = 2; }},
        {"its numbers do not belong together", [](State& s) { s.frame = -1; }},
        {"vertex 5 is no longer finite",
         [](State& s) { s.positions[16] = std::numeric_limits<double>::quiet_NaN(); }},
        {"vertex 0 is no longer finite",
         [](State& s) { s.velocities[1] = std::numeric_limits<double>::infinity(); }},
        {"vertex 9 is more than 1e+09 m away", [](State& s) { s.positions[27] = 1e30; }},
        {"has 143 vertices, the scene 144",
         [](State& s) {
             s.positions.conservativeResize(429);
             s.velocities.conservativeResize(429);
         }},
        {"has 0 vertices, the scene 144",
         [](State& s) {
             s.positions.resize(0);
             s.velocities.resize(0);
         }},
        {"has 0 colliders, the scene 1", [](State& s) { s.collider_on.clear(); }},
        {"has 9 colliders, the scene 1", [](State& s) { s.collider_on.resize(9, 1); }},
        {"has 1 drags, the scene 0", [](State& s) { s.drags.resize(1); }},
        {"has 3 creased folds, the scene 0", [](State& s) { s.rest_folds = VecX::Zero(3); }},
        {"has a time that is no number", [](State& s) { s.time = std::numeric_limits<double>::quiet_NaN(); }},
    };
    for (const Edit& edit : edits) {
        State state = good;
        edit.edit(state);
        pipeline::write_state(state, path);
        for (const char* verb : verbs) {
            INFO(verb);
            check_refusal(place.run(verb), 1, {"o/states/state_000001.bin: ", edit.what});
        }
    }
    CHECK_FALSE(fs::exists(place / "m_000000.obj"));
    // Renamed, with its number left inside.
    pipeline::write_state(good, path);
    fs::rename(place / "o/states/state_000000.bin", place / "aside");
    fs::rename(path, place / "o/states/state_000000.bin");
    fs::rename(place / "aside", path);
    for (const char* verb : verbs)
        check_refusal(place.run(verb), 1, {"o/states/state_000000.bin: is the state of frame 1"});
}

TEST_CASE("a state whose sizes are lies is refused without the memory that it asks for", "[cli][edited]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 3 --no-video").code == 0);
    const fs::path path = place / "o/states/state_000001.bin";
    const std::string good = unpacked(slurp(path));
    // A frame that claims 2^60 bytes and has none of them.
    const std::string claim("\x28\xb5\x2f\xfd\xe0\x00\x00\x00\x00\x00\x00\x00\x10\x01\x00\x00", 16);
    for (const std::string& file : {packed_body("CLOTHST1", claim), packed_body("CLOTHST1", ""),
                                    packed("CLOTHST1", ""), packed("CLOTHST1", good.substr(0, 40)),
                                    packed("CLOTHST1", good + "more"), packed("CLOTHTP1", good)}) {
        spit(path, file);
        for (const char* verb : verbs)
            check_refusal(place.run(verb, "ulimit -v 8000000;"), 1, {"state_000001.bin: "});
    }
}

TEST_CASE("states and topologies with bytes changed under a right checksum never crash a verb",
          "[cli][edited]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 3 --no-video").code == 0);
    std::mt19937 random(20240527);
    const auto pick = [&](std::size_t n) {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    const unsigned seed = GENERATE(range(0u, 12u));
    random.seed(seed);
    struct File {
        const char *name, *magic;
    };
    const File file = seed % 3 == 2 ? File{"topology.bin", "CLOTHTP1"} : File{"state_000001.bin", "CLOTHST1"};
    const fs::path path = place / "o/states" / file.name;
    std::string payload = unpacked(slurp(path));
    // The head, with all its counts, as often as all the rest.
    for (std::size_t k = 0, n = 1 + pick(3); k < n; ++k) {
        const std::size_t at =
            pick(pick(2) == 0 ? std::min<std::size_t>(payload.size(), 64) : payload.size());
        const char values[] = {'\0', '\x7f', '\xff', '\x80', static_cast<char>(pick(256))};
        payload[at] = values[pick(std::size(values))];
    }
    if (pick(4) == 0) payload.resize(pick(payload.size()));
    spit(path, packed(file.magic, payload));
    INFO("seed " << seed);
    check_sound(place.run(verbs[seed % std::size(verbs)]));
}

TEST_CASE("an edited scene, report or picture of a kept run never crashes a verb", "[cli][edited]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 3").code == 0);
    const std::string scene = slurp(place / "o/scene.toml"), report = slurp(place / "o/report.json");
    const auto check_all = [&](const std::vector<std::string>& parts) {
        for (const char* verb : verbs) {
            INFO(verb);
            const Outcome outcome = place.run(verb);
            check_sound(outcome);
            for (const std::string& part : parts) CHECK_THAT(outcome.err, Contains(part));
        }
    };
    spit(place / "o/scene.toml", scene.substr(0, scene.find("[[collider]]") + 5));
    check_all({"o/scene.toml"});
    spit(place / "o/scene.toml", "version = 1\n[simulation]\nframe_rate = 0\n");
    check_all({"o/scene.toml:3:", "frame_rate"});
    spit(place / "o/scene.toml", "");
    check_all({"o/scene.toml", "version"});
    fs::remove(place / "o/scene.toml");
    check_all({"o: holds no run (no scene.toml)"});
    spit(place / "o/scene.toml", scene);
    for (const char* text :
         {"", "{}", "[1, 2]", "{\"frames\": 3}", "{\"frames\": [{\"frame\": \"x\"}]}", "nul", "\xff"}) {
        spit(place / "o/report.json", text);
        check_sound(place.run("render --out o --quiet --curves energy,gap"));
    }
    spit(place / "o/report.json", report);
    for (const char* bytes : {"", "no picture", "\x89PNG\r\n\x1a\n"}) {
        spit(place / "o/frames/frame_000001.png", bytes);
        check_refusal(place.run("encode --out o --quiet"), 1,
                      {"cannot read o/frames/frame_000001.png: not a whole PNG"});
    }
    fs::remove(place / "o/frames/frame_000001.png");
    fs::create_directory(place / "o/frames/frame_000001.png");
    check_sound(place.run("encode --out o --quiet"));
    for (int frame = 0; frame < 3; ++frame)
        fs::remove_all(place / ("o/frames/frame_00000" + std::to_string(frame) + ".png"));
    check_refusal(place.run("encode --out o --quiet"), 1,
                  {"has pictures of 0 of its 3 frames", "render_cloth render --out o"});
    fs::remove_all(place / "o/states/state_000000.bin");
    fs::remove_all(place / "o/states/state_000001.bin");
    fs::remove_all(place / "o/states/state_000002.bin");
    check_refusal(place.run("encode --out o --quiet"), 1, {"the state of frame 0 is missing: no movie"});
    check_refusal(place.run("render --out o --quiet"), 1, {"o: keeps no states"});
}
