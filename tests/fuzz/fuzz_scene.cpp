// Scene text: accepted, or refused with an Error.

#include <cstddef>
#include <cstdint>

#include "pipeline/scene_file/scene_file.h"

using namespace cloth::pipeline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const std::string text(reinterpret_cast<const char*>(data), size);
        // What is accepted loads again from its own text.
        const SceneFile file = parse_scene(text, "s.toml", "/nonexistent");
        parse_scene(file.resolved(), "s.toml", "/nonexistent");
    } catch (const Error&) {
    }
    return 0;
}
