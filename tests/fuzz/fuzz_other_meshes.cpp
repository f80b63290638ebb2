// What assimp reads: its readers may crash in their child process, but nothing of it may reach this one.

#include "fuzz/file_of_input.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_file.h"

using namespace cloth::pipeline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const char* name : {"m.stl", "m.gltf", "m.glb"}) {
        try {
            read_mesh(file_of(data, size, name));
        } catch (const Error&) {
        }
    }
    return 0;
}
