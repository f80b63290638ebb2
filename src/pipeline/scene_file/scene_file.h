#pragma once
// TOML → Scene + View. Strict: an unknown key, a wrong type or an impossible value is an error with file,
// line, column and key, saying what would be right.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/scene_file/picture_desc.h"
#include "render/frame.h"
#include "sim/scene/scene.h"

namespace cloth::pipeline {

/// How a cloth or collider is drawn.
struct Look {
    render::Material material;
    int subdivisions = 0;  ///< Loop steps that smooth the drawn surface (cloth alone)
    double hem = 0;        ///< thickness of the rim as drawn; 0: none (cloth alone) [m]
};

struct OutputDesc {
    int width = 1280, height = 720;       ///< of the pictures [pixel]
    int frames = 300;                     ///< when the command line does not say
    std::optional<double> playback_rate;  ///< frames per second of the movie; default: simulation frame rate
    int quality = 18;                     ///< H.264 constant rate factor, 0 (lossless) … 51
};

/// Portable tolerance of golden states, per scene.
struct ExpectDesc {
    double state_tolerance = 1e-6;  ///< greatest distance of any vertex where the build differs [m]
    std::vector<int> frames;        ///< golden frames
    int frames_simulated = 0;       ///< frames that compare and bless run: the greatest of `frames` + 1
};

struct SceneFile {
    std::string name;  ///< file name without .toml
    std::string description;
    Scene scene;
    render::View view;  ///< size, camera at rest and light
    CameraDesc camera;  ///< how it moves
    AnnotationDesc annotation;
    std::optional<render::Ground> ground;
    std::vector<Look> cloth_looks;     ///< one per cloth
    std::vector<Look> collider_looks;  ///< one per collider
    OutputDesc output;
    ExpectDesc expect;
    std::string resolved;  ///< TOML of this scene with every default written out; loads to the same
};

/// KEY=VALUE over what the file says; VALUE is a TOML value (a bare word counts as a string). `cloth.mesh`
/// reaches the first entry of the table, `cloth[1].mesh` any other. Messages about the value begin with
/// `given`, as the user typed it: "--frames 0"; by default "--set KEY=VALUE".
struct Override {
    std::string setting, given;
    Override(const char* key_is_value) : Override(std::string(key_is_value)) {}
    Override(std::string key_is_value) : setting(std::move(key_is_value)), given("--set " + setting) {}
    Override(std::string key_is_value, std::string as_typed)
        : setting(std::move(key_is_value)), given(std::move(as_typed)) {}
};
using Overrides = std::vector<Override>;

/// A scene by name (looked up in `scene_folders()`) or by path. Meshes are found relative to the scene file,
/// then to the working folder. Throws Error(invalid_scene); an unknown name is answered with the nearest
/// known one.
SceneFile load_scene(const std::string& name_or_path, const Overrides& overrides = {});

/// Loads TOML text; `label` stands for the file in messages, relative paths start at `folder`.
SceneFile parse_scene(const std::string& text, const std::string& label, const std::filesystem::path& folder,
                      const Overrides& overrides = {});

/// Every key of a scene file with its type, unit, range, default and meaning, table by table.
std::string key_reference();

/// Where scenes are looked for: $CLOTH_ASSETS/scenes, then assets/scenes of the source tree.
std::vector<std::filesystem::path> scene_folders();
/// Name and description of every scene there, sorted by name.
std::vector<std::array<std::string, 2>> list_scenes();

}  // namespace cloth::pipeline
