#include "pipeline/formats/fingerprint.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"

namespace cloth::pipeline {

std::string fingerprint(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string file_fingerprint(const std::filesystem::path& path) {
    try {
        return fingerprint(read_file(path));
    } catch (const Error&) {
        return {};
    }
}

}  // namespace cloth::pipeline
