#pragma once
// States on disk: one checksummed file a frame, and a manifest. The only thing between simulation and
// rendering.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/model.h"
#include "sim/scene/state.h"
#include "sim/simulation.h"

namespace cloth::pipeline {

/// Compiler, flags and version that decide the bits of a state: equal fingerprints give equal states.
std::string build_fingerprint();

enum class Compression { fast, small };

/// Doubles as they are, compressed by zstd, checked by a 64-bit xxHash. Written to a temporary name, then
/// renamed.
void write_state(const State& state, const std::filesystem::path& path,
                 Compression compression = Compression::fast);
/// Throws Error(other) naming the file where it is missing, cut short or damaged.
State read_state(const std::filesystem::path& path);
/// xxHash of positions and velocities, 16 hexadecimal digits.
std::string state_hash(const State& state);

/// What a state's numbers belong to.
struct Topology {
    Points rest_positions;  ///< shape (n, 3) [m]
    Triangles triangles;    ///< shape (m, 3)
    std::vector<ClothRange> cloths;
};
void write_topology(const Model& model, const std::filesystem::path& path);
/// Throws as read_state().
Topology read_topology(const std::filesystem::path& path);
/// Whether `model` has exactly these vertices and triangles.
bool same_topology(const Topology& topology, const Model& model);

/// Facts about a run that its scene file does not tell.
struct Manifest {
    std::string scene;        ///< the scene's name
    std::int64_t frames = 0;  ///< frames asked for
    std::string build;        ///< fingerprint of the program that simulated
};

/// The folder of one run: DIR/scene.toml, DIR/meshes/…, DIR/states/state_000000.bin …,
/// DIR/frames/frame_000000.png …, DIR/NAME.mp4, DIR/report.json,
/// DIR/sheet.png.
class RunFolder {
  public:
    /// Throws Error(usage) where `folder` is a file, Error(other) where it cannot be created or written.
    static RunFolder create(const std::filesystem::path& folder);
    /// Throws Error(other) where it holds no run.
    static RunFolder open(const std::filesystem::path& folder);

    std::filesystem::path root() const { return root_; }
    std::filesystem::path scene() const { return root_ / "scene.toml"; }
    std::filesystem::path meshes() const { return root_ / "meshes"; }
    std::filesystem::path textures() const { return root_ / "textures"; }
    std::filesystem::path report() const { return root_ / "report.json"; }
    std::filesystem::path topology() const { return root_ / "states" / "topology.bin"; }
    std::filesystem::path sheet() const { return root_ / "sheet.png"; }  ///< contact sheet
    /// Picture of what overlaps at the start.
    std::filesystem::path overlap() const { return root_ / "overlap.png"; }
    std::filesystem::path state(std::int64_t frame) const;
    std::filesystem::path image(std::int64_t frame) const;
    std::filesystem::path movie(const std::string& scene_name) const { return root_ / (scene_name + ".mp4"); }

    void write_manifest(const Manifest& manifest) const;
    /// Throws Error(other) where it is missing or damaged.
    Manifest read_manifest() const;
    /// Frames whose state is kept, sorted.
    std::vector<std::int64_t> kept_states() const;
    /// Frames whose picture is kept, sorted.
    std::vector<std::int64_t> kept_images() const;
    /// Removes what an earlier run made, and nothing else.
    void clear() const;

  private:
    explicit RunFolder(std::filesystem::path root) : root_(std::move(root)) {}
    std::filesystem::path root_;
};

}  // namespace cloth::pipeline
