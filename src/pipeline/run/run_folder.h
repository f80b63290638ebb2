#pragma once
// The folder of one run.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/formats/folder_lock.h"

namespace cloth::pipeline {

/// Facts about a run that its scene file does not tell.
struct Manifest {
    std::string scene;               ///< the scene's name
    std::int64_t frames = 0;         ///< frames asked for
    std::string build;               ///< fingerprint of the program that simulated
    int format = 0;                  ///< of the states, as state_format; written by write_manifest()
    std::vector<std::string> trunk;  ///< of a branch: keys of the states up to its beginning (fingerprints.h)
};

/// Stands in pages and plots, so that their folder is known for one of this program's.
inline constexpr std::string_view own_mark = "<!-- made by render_cloth -->";

/// Only a new or an empty folder, that of a run, or one that holds nothing but marked files is written into:
/// what is there else is the user's. Throws Error(usage), naming `flag` and what lies there.
void require_own_folder(const std::filesystem::path& folder, const std::string& flag = "--out");

/// states/manifest.json is the first file of a run and stays until the next run's takes its place: a folder
/// with it is a run's. DIR/scene.toml, DIR/meshes/…, DIR/textures/…, DIR/states/state_000000.bin …,
/// DIR/frames/frame_000000.png …, DIR/NAME.mp4, DIR/report.json, DIR/certificate.json, DIR/report.html,
/// DIR/ledger.jsonl, DIR/sheet.png.
class RunFolder {
  public:
    /// For writing, and locked for as long as any copy lives. Throws Error(usage) as require_own_folder(),
    /// Error(other) where it cannot be created or written, or another program writes there.
    static RunFolder create(const std::filesystem::path& folder);
    /// Throws Error(other) where it holds no run.
    static RunFolder open(const std::filesystem::path& folder);
    /// For reading, whatever is there.
    static RunFolder look(const std::filesystem::path& folder) { return RunFolder(folder); }

    std::filesystem::path root() const { return root_; }
    std::filesystem::path scene() const { return root_ / "scene.toml"; }
    std::filesystem::path meshes() const { return root_ / "meshes"; }
    std::filesystem::path textures() const { return root_ / "textures"; }
    std::filesystem::path report() const { return root_ / "report.json"; }
    std::filesystem::path page() const { return root_ / "report.html"; }
    std::filesystem::path certificate() const { return root_ / "certificate.json"; }
    std::filesystem::path ledger() const { return root_ / "ledger.jsonl"; }
    std::filesystem::path topology() const { return root_ / "states" / "topology.bin"; }
    std::filesystem::path sheet() const { return root_ / "sheet.png"; }  ///< contact sheet
    /// Picture of what overlaps at the start.
    std::filesystem::path overlap() const { return root_ / "overlap.png"; }
    std::filesystem::path state(std::int64_t frame) const;
    std::filesystem::path image(std::int64_t frame) const;
    std::filesystem::path movie(const std::string& scene_name) const { return root_ / (scene_name + ".mp4"); }

    void write_manifest(const Manifest& manifest) const;
    /// Throws Error(other) where it is missing, or says what cannot be.
    Manifest read_manifest() const;
    bool has_manifest() const;
    /// Frames of the run whose state is kept, sorted.
    std::vector<std::int64_t> kept_states() const;
    /// Frames of the run whose picture is kept, sorted.
    std::vector<std::int64_t> kept_images() const;
    /// The same with what a longer run has left.
    std::vector<std::int64_t> states_on_disk() const;
    std::vector<std::int64_t> images_on_disk() const;
    /// Unfinished files that a killed program left.
    std::vector<std::filesystem::path> parts() const;
    /// All that runs make here but the manifest, the scene first.
    std::vector<std::filesystem::path> files() const;
    /// One of files(). Throws Error(other).
    void remove(const std::filesystem::path& file) const;
    /// Removes files(), and nothing else.
    void clear() const;

  private:
    std::vector<std::int64_t> of_the_run(std::vector<std::int64_t> frames) const;
    explicit RunFolder(std::filesystem::path root) : root_(std::move(root)) {}
    std::filesystem::path root_;
    std::shared_ptr<const FolderLock> lock_;
};

}  // namespace cloth::pipeline
