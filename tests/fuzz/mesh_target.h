#pragma once
// The way of a mesh from bytes to a cloth.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_draft.h"
#include "sim/scene/mesh.h"
#include "sim/scene/mesh_repair.h"

namespace cloth::pipeline {

/// `read` of the bytes and all that follows it; errors that a user would be told of are no fault.
template <class Read>
int try_mesh(const std::uint8_t* data, std::size_t size, const Read& read) {
    const std::filesystem::path path("m");
    try {
        const std::string_view bytes(reinterpret_cast<const char*>(data), size);
        const LoadedMesh loaded = checked_mesh(read(bytes, path), path, true);
        check_cloth_mesh(repair_cloth_mesh(loaded.mesh, nullptr, true).mesh, "m");
    } catch (const Error&) {
    } catch (const SceneError&) {
    }
    return 0;
}

}  // namespace cloth::pipeline
