#pragma once
// TOML → Scene + View. Strict: an unknown key, a wrong type or an impossible value is an error with file,
// line, column and key, saying what would be right.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/formats/error.h"
#include "pipeline/scene_file/picture_desc.h"
#include "render/frame.h"
#include "sim/scene/scene.h"

namespace cloth::pipeline {

/// How a cloth or collider is drawn, as the renderer takes it.
struct Look {
    render::Material material;
    int subdivisions = 0;  ///< Loop steps that smooth the drawn surface (cloth alone)
    double hem = 0;        ///< thickness of the rim as drawn; 0: none (cloth alone) [m]
};

/// How everything looks, as a scene says it.
struct LooksDesc {
    std::vector<ClothLookDesc> cloths;        ///< one per cloth
    std::vector<ColliderLookDesc> colliders;  ///< one per collider
    LightDesc light;
    std::optional<GroundDesc> ground;
    BackgroundDesc background;
};

/// The keys that name a file ("cloth[0].mesh"), and the files as they are named there.
using FileNames = std::map<std::string, std::string>;

struct SceneFile {
    std::string name;            ///< file name without .toml
    std::filesystem::path path;  ///< of the file that it was read from; empty: of none
    int version = 1;
    std::string description;
    Scene scene;
    LooksDesc looks;
    CameraDesc camera;
    AnnotationDesc annotation;
    OutputDesc output;
    ExpectDesc expect;
    FileNames files;  ///< absolute names of all meshes and textures that were read
    /// What a user should know of how the scene was read, a line each: "cloth[0].mesh: …".
    std::vector<std::string> notes;
    /// Of each cloth whose mesh lost vertices when it was mended: the number in the file of each that it has;
    /// else empty. Pins and seams refer to those that it has.
    std::vector<std::vector<int>> vertices_in_file;
    /// Seams that the file itself has; those behind them are its sewing patterns'.
    std::size_t own_seams = 0;

    // What the renderer takes of the above.
    render::View view;  ///< size, camera at rest and light
    std::optional<render::Ground> ground;
    std::vector<Look> cloth_looks;     ///< one per cloth
    std::vector<Look> collider_looks;  ///< one per collider

    /// TOML of this scene with every default written out; loads to the same. `kept` names files otherwise
    /// than they were read, meshes as they are mended.
    std::string resolved(const FileNames& kept = {}) const;
};

/// KEY=VALUE over what the file says; VALUE is a TOML value (a bare word counts as a string). `cloth.mesh`
/// reaches the first entry of the table, `cloth[1].mesh` any other. Messages about the value begin with
/// `given`, as the user typed it: "--set KEY=VALUE", or the flag that stands for a key: "--frames 0".
struct Override {
    std::string setting, given;
    ExitCode refusal = ExitCode::invalid_scene;  ///< of a bad value; of a flag's it is `usage`
    Override(const char* key_is_value) : Override(std::string(key_is_value)) {}
    Override(std::string key_is_value) : setting(std::move(key_is_value)), given("--set " + setting) {}
    Override(std::string key_is_value, std::string flag)
        : setting(std::move(key_is_value)), given(std::move(flag)), refusal(ExitCode::usage) {}
};
using Overrides = std::vector<Override>;

/// A scene by name (looked up in `scene_folders()`) or by path. Meshes are found relative to the scene file,
/// then to the working folder. Throws Error(invalid_scene); an unknown name is answered with the nearest
/// known one.
SceneFile load_scene(const std::string& name_or_path, const Overrides& overrides = {});

/// Loads TOML text; `label` stands for the file in messages, relative paths start at `folder`.
SceneFile parse_scene(const std::string& text, const std::string& label, const std::filesystem::path& folder,
                      const Overrides& overrides = {});

/// The first key that differs in two scenes, to the bit, or whose vertices, triangles or pixels do; "" where
/// none does. Their names and the files' may differ.
std::string difference(const SceneFile& a, const SceneFile& b);

/// Every key that applies with what it says, meshes and textures by their content: equal where two scenes ask
/// for the same. "cloth[0].fabric": "" for the tables themselves.
std::map<std::string, std::string> values_of(const SceneFile& file);

/// All keys that differ, as difference() finds the first.
std::vector<std::string> differences(const SceneFile& a, const SceneFile& b);

/// Every key of a scene file with its type, unit, range, default and meaning, table by table.
std::string key_reference();

/// The same for editors and other programs: a JSON Schema (draft 2020-12) of scene files as text.
std::string json_schema();

/// Where scenes are looked for: $RENDER_CLOTH_ASSETS/scenes, then beside the program:
/// ../share/render_cloth/scenes where it is installed, assets/scenes where it is built.
std::vector<std::filesystem::path> scene_folders();
/// Name and description of every scene there, sorted by name.
std::vector<std::array<std::string, 2>> list_scenes();
/// One row of Markdown per scene: what happens, vertices of its cloths, steps of its frames. Throws
/// Error(invalid_scene).
std::string scene_rows();

}  // namespace cloth::pipeline
