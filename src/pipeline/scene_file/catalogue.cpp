// Finds scenes by name and lists them.

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <toml++/toml.h>

#include "base/text.h"
#include "pipeline/scene_file/reader.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/scene/mesh.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

std::vector<fs::path> scene_files() {
    std::vector<fs::path> files;
    for (const fs::path& folder : scene_folders()) {
        std::error_code ignored;
        for (const auto& file : fs::directory_iterator(folder, ignored)) {
            if (file.path().extension() == ".toml") files.push_back(file.path());
        }
    }
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return a.stem() < b.stem(); });
    return files;
}

std::string read_text(const fs::path& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) refuse_scene(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
    std::string text;
    char buffer[65536];
    constexpr std::size_t most = std::size_t{1} << 26;  // a device may never end
    for (std::size_t n; text.size() <= most && (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;)
        text.append(buffer, n);
    std::fclose(file);
    if (text.size() > most) refuse_scene(path.string() + ": is larger than 64 MB, which no scene is");
    return text;
}

}  // namespace

SceneFile load_scene(const std::string& name_or_path, const Overrides& overrides) {
    std::error_code ignored;
    fs::path path(name_or_path);
    const bool looks_like_path = path.extension() == ".toml" || path.has_parent_path();
    if (!looks_like_path) {
        std::vector<std::string> known;
        path.clear();
        for (const fs::path& file : scene_files()) {
            known.push_back(file.stem().string());
            if (path.empty() && known.back() == name_or_path) path = file;
        }
        if (path.empty()) {
            const std::string near = nearest_word(name_or_path, known);
            refuse_scene(fmt::format("unknown scene \"{}\"; {}(known: {})", name_or_path,
                                     near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near),
                                     join(known)));
        }
    }
    if (!fs::exists(path, ignored)) {
        refuse_scene(fmt::format("{}: there is no such scene file", path.string()));
    }
    if (fs::is_directory(path, ignored)) {
        refuse_scene(fmt::format("{}: is a folder; a scene is a .toml file", path.string()));
    }
    SceneFile file = parse_scene(read_text(path), path.string(), fs::absolute(path).parent_path(), overrides);
    file.path = path;
    return file;
}

std::vector<fs::path> scene_folders() {
    std::vector<fs::path> folders;
    if (const char* assets = std::getenv("RENDER_CLOTH_ASSETS"))
        folders.push_back(fs::path(assets) / "scenes");
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    // In a build folder `assets` is a link to the source tree's.
    for (const char* assets : {"../share/render_cloth", "assets"})
        folders.push_back((program / assets / "scenes").lexically_normal());
    return folders;
}

std::vector<std::array<std::string, 2>> list_scenes() {
    std::vector<std::array<std::string, 2>> result;
    for (const fs::path& file : scene_files()) {
        const std::string name = file.stem().string();
        if (!result.empty() && result.back()[0] == name) continue;
        std::string description;
        try {
            description = toml::parse_file(file.string())["description"].value_or(std::string());
        } catch (const toml::parse_error&) {
            description = "(cannot be read)";
        }
        result.push_back({name, description});
    }
    return result;
}

std::string scene_rows() {
    std::string text = "| scene | what happens | vertices | steps |\n|-|-|-:|-:|\n";
    for (const auto& [name, description] : list_scenes()) {
        const SceneFile file = load_scene(name);
        Eigen::Index vertices = 0;
        for (const ClothDesc& cloth : file.scene.cloths) vertices += rest_shape(cloth).positions.rows();
        text += fmt::format("| `{}` | {} | {} | {} |\n", name, description, vertices,
                            (file.output.frames - 1) * file.scene.simulation.steps_per_frame());
    }
    return text;
}

}  // namespace cloth::pipeline
