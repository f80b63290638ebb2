#pragma once
// What a scene needs of memory, before it is taken.

#include <cstddef>
#include <string>

#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

/// About how much, and the key that most of it comes from.
struct MemoryNeed {
    std::string key;
    double bytes = 0.0;
};

/// Of the start poses alone, as reading a scene needs them.
MemoryNeed reading_need(const Scene& scene);
/// Of the energies, their pattern and its factor, as measured on grids of 3600 to 57600 vertices.
MemoryNeed simulation_need(const Scene& scene);
/// Of drawn surfaces and pictures, as measured.
MemoryNeed picture_need(const SceneFile& file);

/// Throws SceneError under the need's key where there are fewer than `available` bytes for it.
void require_memory(const MemoryNeed& need, std::size_t available);

}  // namespace cloth::pipeline
