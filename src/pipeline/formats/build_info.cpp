#include "pipeline/formats/build_info.h"

#include <fmt/format.h>

#include <Eigen/Core>

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

}  // namespace cloth::pipeline
