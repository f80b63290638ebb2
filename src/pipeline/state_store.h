#pragma once
// States on disk: one checksummed file a frame, and a manifest. The only thing between simulation and rendering.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/model.h"
#include "sim/simulation.h"
#include "sim/state.h"

namespace cloth::pipeline {

/// Compiler, flags and version that decide the bits of a state: equal fingerprints give equal states.
std::string build_fingerprint();

/// Doubles as they are, compressed by zstd, checked by a 64-bit xxHash. Written to a temporary name, then renamed.
void write_state(const State& state, const std::filesystem::path& path);
/// Throws Error naming the file where it is missing, cut short or damaged.
State read_state(const std::filesystem::path& path);
/// xxHash of positions and velocities, 16 hexadecimal digits.
std::string state_hash(const State& state);

/// The folder of one run: DIR/scene.toml, DIR/states/state_000000.bin …, DIR/frames/…, DIR/NAME.mp4,
/// DIR/report.json.
class RunFolder {
  public:
    /// Throws Error(other) where `folder` cannot be created or written.
    static RunFolder create(const std::filesystem::path& folder);
    /// Throws Error(other) where it holds no run.
    static RunFolder open(const std::filesystem::path& folder);

    std::filesystem::path root() const { return root_; }
    std::filesystem::path scene() const { return root_ / "scene.toml"; }
    std::filesystem::path state(std::int64_t frame) const;
    std::filesystem::path image(std::int64_t frame) const;  ///< DIR/frames/NAME_000000.png … numbering of %06d
    /// Frames whose state is kept, sorted.
    std::vector<std::int64_t> kept_states() const;
    /// Removes states and pictures of an earlier run, and nothing else.
    void clear();

  private:
    std::filesystem::path root_;
};

}  // namespace cloth::pipeline
