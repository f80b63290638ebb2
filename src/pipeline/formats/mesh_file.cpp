// OBJ and PLY have readers of their own; everything else is read by assimp. assimp keeps floats, splits an
// OBJ's vertices wherever corners differ in normal or texture coordinate, and numbers them by first use; a
// cloth needs the file's own vertices, in their order, to the last digit: pins name them, and states are
// compared vertex by vertex.

#include "pipeline/formats/mesh_file.h"

#include <string>
#include <system_error>

#include "pipeline/formats/assimp_import.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/ply.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

LoadedMesh read_any(const fs::path& path, bool faces_wanted) {
    const FilePlace place{path};
    std::error_code problem;
    if (fs::is_directory(path, problem)) place.fail("is a folder, not a mesh file");
    if (!fs::exists(path, problem)) place.fail("there is no such file");
    std::string text;
    try {
        text = read_file(path);
    } catch (const Error& e) {
        throw Error(ExitCode::invalid_scene, e.what());
    }
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) place.fail("is empty");
    const std::string extension = extension_of(path);
    if (extension == ".obj") return checked_mesh(read_obj(text, path), path, faces_wanted);
    if (extension == ".ply") return checked_mesh(read_ply(text, path), path, faces_wanted);
    return checked_mesh(import_by_assimp(path, extension), path, faces_wanted);
}

}  // namespace

LoadedMesh read_mesh(const fs::path& path) {
    return read_any(path, true);
}

LoadedMesh read_points(const fs::path& path) {
    return read_any(path, false);
}

}  // namespace cloth::pipeline
