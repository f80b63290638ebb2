// Meshes that bend: read, or refused with an Error.

#include "fuzz/file_of_input.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_cache_file.h"

using namespace cloth::pipeline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const char* name : {"m.pc2", "m.mdd", "m.npz"}) {
        try {
            read_mesh_cache(file_of(data, size, name));
        } catch (const Error&) {
        }
    }
    return 0;
}
