#include "pipeline/run/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

std::string numbered(std::string_view stem, std::int64_t frame, std::string_view extension) {
    return fmt::format("{}_{:06d}{}", stem, frame, extension);
}

/// The frame in "stem_000012.ext"; nothing for any other name.
std::optional<std::int64_t> frame_of(const std::string& name, std::string_view stem,
                                     std::string_view extension) {
    const std::size_t around = stem.size() + 1 + extension.size();
    if (name.size() < around + 6 || name.size() > around + 12) return std::nullopt;
    const std::string digits = name.substr(stem.size() + 1, name.size() - around);
    if (!std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }))
        return std::nullopt;
    const std::int64_t frame = std::stoll(digits);
    if (name != numbered(stem, frame, extension)) return std::nullopt;
    return frame;
}

std::vector<std::int64_t> frames_in(const fs::path& folder, std::string_view stem,
                                    std::string_view extension) {
    std::vector<std::int64_t> frames;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder, missing))
        if (const auto frame = frame_of(entry.path().filename().string(), stem, extension))
            frames.push_back(*frame);
    std::sort(frames.begin(), frames.end());
    return frames;
}

}  // namespace

RunFolder RunFolder::create(const fs::path& folder) {
    std::error_code failure;
    if (fs::exists(folder, failure) && !fs::is_directory(folder, failure))
        throw Error(ExitCode::usage, "--out " + folder.string() + ": is a file; give a folder");
    for (const char* part : {"states", "frames"}) {
        fs::create_directories(folder / part, failure);
        if (failure)
            throw Error(ExitCode::other,
                        "cannot write to the folder " + folder.string() + ": " + failure.message());
    }
    return RunFolder(folder);
}

RunFolder RunFolder::open(const fs::path& folder) {
    RunFolder run(folder);
    std::error_code failure;
    if (!fs::is_regular_file(run.scene(), failure))
        throw Error(ExitCode::other, folder.string() + ": holds no run (no scene.toml); make one with " +
                                         "render_cloth simulate --scene NAME --out " + folder.string());
    return run;
}

fs::path RunFolder::state(std::int64_t frame) const {
    return root_ / "states" / numbered("state", frame, ".bin");
}

fs::path RunFolder::image(std::int64_t frame) const {
    return root_ / "frames" / numbered("frame", frame, ".png");
}

void RunFolder::write_manifest(const Manifest& manifest) const {
    const nlohmann::ordered_json json = {{"format", state_format},
                                         {"scene", manifest.scene},
                                         {"frames", manifest.frames},
                                         {"build", manifest.build}};
    write_file(root_ / "states" / "manifest.json", json.dump(2) + "\n");
}

Manifest RunFolder::read_manifest() const {
    const fs::path path = root_ / "states" / "manifest.json";
    try {
        const auto json = nlohmann::json::parse(read_file(path));
        return {json.at("scene"), json.at("frames"), json.at("build")};
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::other, path.string() + ": damaged");
    }
}

std::vector<std::int64_t> RunFolder::kept_states() const {
    return frames_in(root_ / "states", "state", ".bin");
}
std::vector<std::int64_t> RunFolder::kept_images() const {
    return frames_in(root_ / "frames", "frame", ".png");
}

void RunFolder::clear() const {
    std::error_code failure;
    // Without a manifest the folder is no run's: there is nothing of ours that names itself.
    if (!fs::exists(root_ / "states" / "manifest.json", failure)) return;
    std::vector<fs::path> ours = {scene(), report(), topology(), sheet(), overlap()};
    try {
        const std::string name = read_manifest().scene;
        if (fs::path(name).filename() == name) {
            ours.push_back(movie(name));
            ours.push_back(movie(name).string() + ".part");
        }
    } catch (const Error&) {
        // A damaged manifest leaves the movie standing; its name is unknown.
    }
    for (const std::int64_t frame : kept_states()) ours.push_back(state(frame));
    for (const std::int64_t frame : kept_images()) ours.push_back(image(frame));
    // What a killed run left behind.
    for (const std::int64_t frame : frames_in(root_ / "states", "state", ".bin.part"))
        ours.push_back(state(frame).string() + ".part");
    for (const std::int64_t frame : frames_in(root_ / "frames", "frame", ".png.part"))
        ours.push_back(image(frame).string() + ".part");
    for (const char* stem : {"rest", "pose", "collider"})
        for (const std::int64_t number : frames_in(meshes(), stem, ".obj"))
            ours.push_back(meshes() / numbered(stem, number, ".obj"));
    for (const std::int64_t cloth : frames_in(textures(), "cloth", ".png"))
        ours.push_back(textures() / numbered("cloth", cloth, ".png"));
    ours.push_back(root_ / "states" / "manifest.json");  // last: an interrupted clear can be repeated
    for (const fs::path& file : ours) {
        fs::remove(file, failure);
        if (failure)
            throw Error(ExitCode::other, "cannot remove " + file.string() + ": " + failure.message());
    }
    fs::remove(meshes(), failure);  // fails, rightly, where something else lies in it
    fs::remove(textures(), failure);
}

}  // namespace cloth::pipeline
