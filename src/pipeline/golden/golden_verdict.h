#pragma once
// A comparison with goldens as other programs read it.

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "pipeline/golden/golden.h"

namespace cloth::pipeline {

/// What golden_table() says: scene, verdict, builds and renderers, and each frame's state and picture.
nlohmann::ordered_json golden_json(const GoldenResult& result);

/// The same as JUnit's XML, which CI servers show: a test case for each frame's state and each frame's
/// picture.
std::string golden_junit(const GoldenResult& result);

}  // namespace cloth::pipeline
