// OBJ meshes: read, or refused with an Error; what is read can be mended and checked.

#include "fuzz/mesh_target.h"
#include "pipeline/formats/obj.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return cloth::pipeline::try_mesh(data, size, cloth::pipeline::read_obj);
}
