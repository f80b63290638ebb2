#include "pipeline/run/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "base/whole_file.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/scene_file/picture_schema.h"

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

fs::path manifest_of(const fs::path& folder) {
    return folder / "states" / "manifest.json";
}

bool is_marked(const fs::path& path) {
    std::string head(own_mark.size() + 200, '\0');
    std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
    return head.find(own_mark) != std::string::npos;
}

/// What lies in a folder that no run has got to its manifest in, and is not this program's; empty: nothing.
std::string foreign_file(const fs::path& folder) {
    std::error_code failure;
    fs::recursive_directory_iterator entry(folder, failure), end;
    for (; !failure && entry != end; entry.increment(failure)) {
        const fs::path& path = entry->path();
        const std::string name = path.filename().string();
        const bool regular = fs::symlink_status(path, failure).type() == fs::file_type::regular;
        if (entry->is_directory(failure) && !entry->is_symlink(failure)) continue;
        if (regular && (name == lock_name || target_of_part(name) == "manifest.json" || is_marked(path)))
            continue;
        return path.lexically_relative(folder).string();
    }
    return failure ? "what cannot be read: " + failure.message() : std::string();
}

/// A name that leads nowhere else.
bool is_plain_name(const std::string& name) {
    return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
           name.find('\0') == std::string::npos;
}

Manifest manifest_in(const fs::path& folder) {
    const fs::path path = manifest_of(folder);
    const auto damaged = [&](const char* what) -> Error {
        return {ExitCode::other, path.string() + ": damaged: " + what};
    };
    const nlohmann::json json = nlohmann::json::parse(read_file(path), nullptr, false);
    if (!json.is_object()) throw damaged("no JSON object");
    for (const char* key : {"format", "scene", "frames", "build"})
        if (!json.contains(key)) throw damaged("it lacks format, scene, frames or build");
    if (!json["scene"].is_string() || !is_plain_name(json["scene"].get<std::string>()))
        throw damaged("scene must be a scene's name");
    if (!json["frames"].is_number_integer() || json["frames"] < 1 || json["frames"] > most_frames)
        throw damaged(fmt::format("frames must be 1 … {}", most_frames).c_str());
    if (!json["format"].is_number_integer() || json["format"] < 1 || json["format"] > 1000)
        throw damaged("format must be a whole number");
    if (!json["build"].is_string()) throw damaged("build must be a text");
    Manifest manifest{json["scene"], json["frames"], json["build"], json["format"], {}};
    if (json.contains("trunk")) {
        for (const nlohmann::json& key : json["trunk"]) {
            if (!key.is_string()) throw damaged("trunk must be a list of keys");
            manifest.trunk.push_back(key);
        }
    }
    return manifest;
}

}  // namespace

void require_own_folder(const fs::path& folder, const std::string& flag) {
    std::error_code failure;
    const std::string place = flag + " " + folder.string();
    const fs::file_status status = fs::status(folder, failure);
    if (status.type() == fs::file_type::not_found) return;
    if (fs::exists(status) && !fs::is_directory(status))
        throw Error(ExitCode::usage, place + ": is a file; give a folder");
    std::string damage;
    if (fs::exists(manifest_of(folder), failure)) {
        try {
            manifest_in(folder);
            return;
        } catch (const Error& e) {
            damage = fmt::format(" ({})", e.what());
        }
    }
    if (const std::string foreign = foreign_file(folder); !foreign.empty())
        throw Error(ExitCode::usage,
                    fmt::format("{}: holds {}, and no run{}; give a new folder, an empty one, or a run's",
                                place, foreign, damage));
}

RunFolder RunFolder::create(const fs::path& folder) {
    require_own_folder(folder);
    std::error_code failure;
    const auto require = [&](bool done) {
        if (!done && failure)
            throw Error(ExitCode::other,
                        "cannot write to the folder " + folder.string() + ": " + failure.message());
    };
    require(fs::create_directories(folder, failure));
    RunFolder run(folder);
    run.lock_ = std::make_shared<const FolderLock>(folder);
    require_own_folder(folder);  // it may have been filled since
    for (const char* part : {"states", "frames"}) require(fs::create_directories(folder / part, failure));
    return run;
}

RunFolder RunFolder::open(const fs::path& folder) {
    RunFolder run(folder);
    std::error_code failure;
    for (const fs::path& file : {run.scene(), manifest_of(folder)})
        if (!fs::is_regular_file(file, failure))
            throw Error(ExitCode::other,
                        fmt::format("{0}: holds no run (no {1}); make one with render_cloth simulate --scene "
                                    "NAME --out {0}",
                                    folder.string(), file.lexically_relative(folder).string()));
    return run;
}

fs::path RunFolder::state(std::int64_t frame) const {
    return root_ / "states" / numbered("state", frame, ".bin");
}

fs::path RunFolder::image(std::int64_t frame) const {
    return root_ / "frames" / numbered("frame", frame, ".png");
}

void RunFolder::write_manifest(const Manifest& manifest) const {
    nlohmann::ordered_json json = {{"format", state_format},
                                   {"scene", manifest.scene},
                                   {"frames", manifest.frames},
                                   {"build", manifest.build}};
    if (!manifest.trunk.empty()) json["trunk"] = manifest.trunk;
    write_if_changed(manifest_of(root_), json.dump(2) + "\n");
}

Manifest RunFolder::read_manifest() const {
    return manifest_in(root_);
}

bool RunFolder::has_manifest() const {
    std::error_code missing;
    return fs::exists(manifest_of(root_), missing);
}

std::vector<std::int64_t> RunFolder::states_on_disk() const {
    return frames_in(root_ / "states", "state", ".bin");
}
std::vector<std::int64_t> RunFolder::images_on_disk() const {
    return frames_in(root_ / "frames", "frame", ".png");
}

std::vector<std::int64_t> RunFolder::kept_states() const {
    return of_the_run(states_on_disk());
}
std::vector<std::int64_t> RunFolder::kept_images() const {
    return of_the_run(images_on_disk());
}

std::vector<std::int64_t> RunFolder::of_the_run(std::vector<std::int64_t> frames) const {
    if (has_manifest()) {
        const std::int64_t end = read_manifest().frames;
        std::erase_if(frames, [end](std::int64_t frame) { return frame >= end; });
    }
    return frames;
}

std::vector<fs::path> RunFolder::files() const {
    std::error_code failure;
    std::string movie_name;
    if (has_manifest()) movie_name = movie(read_manifest().scene).filename().string();
    struct Part {
        fs::path folder;
        std::vector<std::string> names;                                     ///< as they are
        std::vector<std::pair<std::string_view, std::string_view>> series;  ///< stem and extension
    };
    // The scene goes first: without it there is nothing to be drawn again from what is left.
    const Part parts[] = {
        {root_,
         {"scene.toml", "report.json", "certificate.json", "report.html", "ledger.jsonl", "sheet.png",
          "overlap.png", movie_name},
         {}},
        {root_ / "states", {"topology.bin"}, {{"state", ".bin"}}},
        {root_ / "frames", {}, {{"frame", ".png"}}},
        {meshes(), {}, {{"rest", ".obj"}, {"pose", ".obj"}, {"collider", ".obj"}, {"cache", ".npz"}}},
        {textures(), {}, {{"cloth", ".png"}}},
    };
    std::vector<fs::path> all;
    for (const Part& part : parts) {
        const auto is_ours = [&](const std::string& name) {
            if (name.empty()) return false;
            return std::find(part.names.begin(), part.names.end(), name) != part.names.end() ||
                   std::any_of(part.series.begin(), part.series.end(), [&](const auto& each) {
                       return frame_of(name, each.first, each.second).has_value();
                   });
        };
        std::vector<fs::path> ours;
        for (const auto& entry : fs::directory_iterator(part.folder, failure)) {
            const std::string name = entry.path().filename().string();
            const std::string target = target_of_part(name);  // a killed run left it
            if (is_ours(name) || is_ours(target) || target == "manifest.json") ours.push_back(entry.path());
        }
        std::sort(ours.begin(), ours.end(), [&](const fs::path& a, const fs::path& b) {
            return std::pair(a != scene(), a) < std::pair(b != scene(), b);
        });
        all.insert(all.end(), ours.begin(), ours.end());
    }
    return all;
}

std::vector<fs::path> RunFolder::parts() const {
    std::vector<fs::path> left = files();
    std::erase_if(left,
                  [](const fs::path& file) { return target_of_part(file.filename().string()).empty(); });
    return left;
}

void RunFolder::remove(const fs::path& file) const {
    std::error_code failure;
    if (!fs::is_directory(fs::symlink_status(file, failure))) fs::remove(file, failure);
    if (failure && failure != std::errc::no_such_file_or_directory)
        throw Error(ExitCode::other, "cannot remove " + file.string() + ": " + failure.message());
}

void RunFolder::clear() const {
    for (const fs::path& file : files()) remove(file);
    std::error_code failure;
    fs::remove(meshes(), failure);  // fails, rightly, where something else lies in it
    fs::remove(textures(), failure);
}

}  // namespace cloth::pipeline
