// States on disk: read, or refused with an Error.

#include "fuzz/file_of_input.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"

using namespace cloth::pipeline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto path = file_of(data, size, "state.bin");
    try {
        read_state(path);
    } catch (const Error&) {
    }
    try {
        read_topology(path);
    } catch (const Error&) {
    }
    return 0;
}
