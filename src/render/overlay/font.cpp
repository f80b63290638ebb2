#include "render/overlay/font.h"

// The assembler takes the file in as it is; CMake names it.
__asm__(
    ".pushsection .rodata\n"
    ".balign 16\n"
    "cloth_font_begin:\n"
    ".incbin \"" CLOTH_FONT_FILE
    "\"\n"
    "cloth_font_end:\n"
    ".popsection\n");

extern "C" {
extern const unsigned char cloth_font_begin[];
extern const unsigned char cloth_font_end[];
}

namespace cloth::render {

std::span<const unsigned char> font_bytes() {
    return {cloth_font_begin, cloth_font_end};
}

}  // namespace cloth::render
