#pragma once
// The bytes of DejaVu Sans, a part of the program so that pictures do not depend on the fonts of a machine.

#include <span>

namespace cloth::render {

std::span<const unsigned char> font_bytes();

}  // namespace cloth::render
