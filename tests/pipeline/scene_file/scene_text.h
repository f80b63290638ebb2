#pragma once
// Scenes as text for tests, and what a bad one is refused with.

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "pipeline/formats/error.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

inline SceneFile parse(const std::string& text, const Overrides& overrides = {}) {
    return parse_scene(text, "s.toml", std::filesystem::temp_directory_path(), overrides);
}

/// A sheet and `more`, under the version line: `more` begins at line 3.
inline std::string sheet(const std::string& more = "") {
    return "version = 1\n[[cloth]]\n" + more;
}

/// The one line that `action` is refused with, as a scene that is not valid; "" where it is not.
template <class Action>
std::string refusal_of(const Action& action) {
    try {
        action();
    } catch (const Error& e) {
        CHECK(e.code == ExitCode::invalid_scene);
        CHECK(std::string(e.what()).find('\n') == std::string::npos);
        return e.what();
    }
    return "";
}
inline std::string refusal(const std::string& text, const Overrides& overrides = {}) {
    return refusal_of([&] { parse(text, overrides); });
}

}  // namespace cloth::pipeline
