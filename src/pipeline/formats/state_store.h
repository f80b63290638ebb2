#pragma once
// States on disk: one checksummed file a frame. The only thing between simulation and rendering.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/whole_file.h"
#include "sim/model.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

/// Version of the files that write_state() writes and read_state() reads.
inline constexpr int state_format = 2;

enum class Compression { fast, small };

/// Doubles as they are, compressed by zstd, checked by a 64-bit xxHash. Written to a temporary name, then
/// renamed. Gives the file's fingerprint().
std::string write_state(const State& state, const std::filesystem::path& path,
                        Compression compression = Compression::fast, Sync sync = Sync::no);
/// Throws Error(other) naming the file where it is missing, cut short or damaged.
State read_state(const std::filesystem::path& path);
/// All that a state holds, before compression: equal bytes mean equal states.
std::string state_bytes(const State& state);
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

}  // namespace cloth::pipeline
