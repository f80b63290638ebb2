#pragma once
// Fingerprints of bytes: equal where the bytes are, and in practice only there.

#include <filesystem>
#include <string>
#include <string_view>

namespace cloth::pipeline {

/// 128-bit xxHash, 32 hexadecimal digits.
std::string fingerprint(std::string_view bytes);

/// Of a file's bytes; empty where it cannot be read.
std::string file_fingerprint(const std::filesystem::path& path);

}  // namespace cloth::pipeline
