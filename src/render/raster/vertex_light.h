#pragma once
// Light from above and below at each vertex: computed at some, spread from there over the others.

#include <cstddef>

#include "render/raster/ambient_occlusion.h"
#include "render/raster/mesh_list.h"
#include "render/raster/shot.h"

namespace cloth::render {

/// Sets the ambient light of all vertices in `list`. `occlusion` of the frame's surfaces is asked where the
/// shot wants it. The number of threads changes nothing.
void light_vertices(const Shot& shot, const AmbientOcclusion& occlusion, std::size_t threads, MeshList& list);

}  // namespace cloth::render
