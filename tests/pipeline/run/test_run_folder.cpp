// The folder of a run: what is found in it, and what is removed from it.

#include <algorithm>
#include <catch2/catch.hpp>

#include "pipeline/run/run_folder.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("clearing a run's folder removes the run and nothing else", "[run_folder]") {
    const TemporaryFolder folder;
    const RunFolder run = RunFolder::create(folder.path());
    run.write_manifest({"drape", 13, "a build"});
    CHECK(run.read_manifest().scene == "drape");
    CHECK(run.read_manifest().frames == 13);
    spit(run.state(0), "a state");
    spit(run.state(12), "a state");
    spit(run.image(12), "a picture");
    spit(run.scene(), "version = 1");
    spit(run.report(), "{}");
    spit(run.certificate(), "{}");
    spit(run.ledger(), "");
    spit(run.movie("drape"), "a movie");
    fs::create_directory(run.meshes());
    spit(run.meshes() / "rest_000000.obj", "v 0 0 0");
    spit(run.meshes() / "collider_000002.obj", "v 0 0 0");
    fs::create_directory(run.textures());
    spit(run.textures() / "cloth_000000.png", "a print");
    for (const char* left : {".part", ".12-0.part"})
        spit(run.image(3).string() + left, "what a killed run left");
    spit(run.movie("drape").string() + ".12-3.part", "what a killed run left");
    CHECK(run.kept_states() == std::vector<std::int64_t>{0, 12});
    CHECK(run.kept_images() == std::vector<std::int64_t>{12});
    const std::vector<std::string> foreign = {"notes.txt",
                                              "other.mp4",
                                              "frames/photo.png",
                                              "frames/frame_1.png",
                                              "frames/photo.png.12-0.part",
                                              "states/state_abcdef.bin",
                                              "meshes/mine.obj",
                                              "textures/print.png"};
    for (const std::string& name : foreign) spit(folder / name, "mine");
    run.clear();
    std::vector<std::string> left;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
        if (entry.is_regular_file()) left.push_back(fs::relative(entry.path(), folder.path()).string());
    std::vector<std::string> expected = foreign;
    // The manifest stays until the next one takes its place, the lock as long as the folder is held.
    expected.insert(expected.end(), {"run.lock", "states/manifest.json"});
    std::sort(left.begin(), left.end());
    std::sort(expected.begin(), expected.end());
    CHECK(left == expected);
}

TEST_CASE("a folder that cannot be a run's is refused with the reason", "[run_folder]") {
    const TemporaryFolder folder;
    spit(folder / "file", "x");
    CHECK_THAT(message_of([&] { RunFolder::create(folder / "file"); }, ExitCode::usage),
               Contains("is a file; give a folder"));
    CHECK_THAT(message_of([&] { RunFolder::create(folder / "file/below"); }, ExitCode::other),
               Contains("cannot write to the folder") && Contains("Not a directory"));
    CHECK_THAT(message_of([&] { RunFolder::open(folder / "none"); }, ExitCode::other),
               Contains("holds no run") && Contains("render_cloth simulate"));
}
