#pragma once
// JSON files that others made.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace cloth::pipeline {

/// The file's one object. Throws Error(invalid_scene): missing, no JSON (with line and column), no object.
nlohmann::json read_json_object(const std::filesystem::path& path);

}  // namespace cloth::pipeline
