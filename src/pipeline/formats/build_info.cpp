#include "pipeline/formats/build_info.h"

#include <fmt/format.h>

#include <Eigen/Core>

#include "pipeline/formats/source_fingerprints.h"
#include "pipeline/formats/state_store.h"

namespace cloth::pipeline {

std::string program_version() {
    return CLOTH_VERSION;
}

std::string compiler() {
#if defined(__clang__)
    return "clang " __clang_version__;
#else
    return "g++ " __VERSION__;
#endif
}

std::string build_fingerprint() {
    return fmt::format("{}; {}; Eigen {}.{}.{}; state format {}", compiler(), CLOTH_BUILD_FLAGS,
                       EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, state_format);
}

std::string physics_sources() {
    return CLOTH_PHYSICS_SOURCES;
}

std::string all_sources() {
    return CLOTH_ALL_SOURCES;
}

}  // namespace cloth::pipeline
