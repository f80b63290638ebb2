#include "pipeline/formats/assimp_import.h"

#include <assimp/importerdesc.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/BaseImporter.h>
#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

/// Appends the meshes of a node and of those below it, moved to where the nodes stand.
void append(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent, const FilePlace& place,
            MeshDraft& draft) {
    const Eigen::Matrix4d world = parent * matrix_of(node.mTransformation);
    const bool moved = !world.isIdentity(0.0);
    std::vector<std::int64_t> corners;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
        const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
        const auto first = static_cast<std::int64_t>(draft.positions.size());
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D& p = mesh.mVertices[v];
            Eigen::Vector4d x(p.x, p.y, p.z, 1.0);
            if (moved) x = world * x;
            if (!x.allFinite()) {
                place.fail(fmt::format("vertex {} (counted from 0) is not finite", draft.positions.size()));
            }
            draft.positions.push_back({x(0), x(1), x(2)});
        }
        std::set<std::string> names{node.mName.C_Str(), mesh.mName.C_Str()};
        if (mesh.mMaterialIndex < scene.mNumMaterials)
            names.insert(scene.mMaterials[mesh.mMaterialIndex]->GetName().C_Str());
        names.erase("");
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices < 3) continue;
            corners.clear();
            for (unsigned k = 0; k < face.mNumIndices; ++k) {
                corners.push_back(first + face.mIndices[k]);
                constexpr double none = std::numeric_limits<double>::quiet_NaN();
                const aiVector3D* uv = mesh.mTextureCoords[0];
                draft.uv.push_back(uv ? std::array<double, 2>{uv[face.mIndices[k]].x, uv[face.mIndices[k]].y}
                                      : std::array<double, 2>{none, none});
            }
            for (const std::string& name : names) draft.parts[name].push_back(draft.face_count());
            draft.add_face(corners);
        }
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) append(scene, *node.mChildren[i], world, place, draft);
}

/// An STL has no vertex list: equal coordinates are its only way to say that triangles share a corner.
void join_equal_positions(MeshDraft& draft) {
    std::map<std::array<double, 3>, std::int64_t> seen;
    std::vector<std::int64_t> joined;
    std::vector<std::array<double, 3>> kept;
    for (const auto& p : draft.positions) {
        const auto [at, is_new] = seen.emplace(p, static_cast<std::int64_t>(kept.size()));
        if (is_new) kept.push_back(p);
        joined.push_back(at->second);
    }
    draft.positions = std::move(kept);
    for (auto& v : draft.corners) v = joined[static_cast<std::size_t>(v)];
}

// ---------------------------------------------------------------- a draft as bytes, from process to process

template <class T>
void put(std::string& bytes, const std::vector<T>& values) {
    const std::size_t count = values.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes.append(reinterpret_cast<const char*>(values.data()), count * sizeof(T));
}

template <class T>
void take(std::string_view& bytes, std::vector<T>& values) {
    std::size_t count = 0;
    std::memcpy(&count, bytes.data(), sizeof count);
    bytes.remove_prefix(sizeof count);
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(T));
    bytes.remove_prefix(count * sizeof(T));
}

std::string bytes_of(const MeshDraft& draft) {
    std::string bytes;
    put(bytes, draft.positions);
    put(bytes, draft.corners);
    put(bytes, draft.ends);
    put(bytes, draft.uv);
    put(bytes, std::vector<std::size_t>{draft.parts.size()});
    for (const auto& [name, faces] : draft.parts) {
        put(bytes, std::vector<char>(name.begin(), name.end()));
        put(bytes, faces);
    }
    return bytes + join(draft.notes, "\n");
}

MeshDraft draft_of(std::string_view bytes) {
    MeshDraft draft;
    take(bytes, draft.positions);
    take(bytes, draft.corners);
    take(bytes, draft.ends);
    take(bytes, draft.uv);
    std::vector<std::size_t> parts;
    take(bytes, parts);
    for (std::size_t i = 0; i < parts.at(0); ++i) {
        std::vector<char> name;
        take(bytes, name);
        take(bytes, draft.parts[std::string(name.begin(), name.end())]);
    }
    if (!bytes.empty()) draft.notes = split(std::string(bytes), '\n');
    return draft;
}

/// Leaves the importer no reader but those of the extension: left alone it asks all of them.
void keep_readers_of(const std::string& extension, Assimp::Importer& importer) {
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        const std::vector<std::string> theirs = split(importer.GetImporterInfo(i)->mFileExtensions, ' ');
        if (std::find(theirs.begin(), theirs.end(), extension.substr(1)) != theirs.end()) continue;
        Assimp::BaseImporter* other = importer.GetImporter(i);
        importer.UnregisterLoader(other);
        delete other;
    }
}

}  // namespace

Eigen::Matrix4d matrix_of(const aiMatrix4x4& m) {
    Eigen::Matrix4d result;
    for (unsigned r = 0; r < 4; ++r)
        for (unsigned c = 0; c < 4; ++c) result(r, c) = m[r][c];
    return result;
}

const aiScene& open_scene(Assimp::Importer& importer, const fs::path& path, const std::string& extension) {
    keep_readers_of(extension, importer);
    const aiScene* scene = importer.ReadFile(path.string(), 0);
    if (scene == nullptr || scene->mRootNode == nullptr)
        FilePlace{path}.fail(std::string("cannot be read as a mesh: ") + importer.GetErrorString());
    return *scene;
}

std::string read_in_child(const fs::path& path, const std::string& extension, ChildLimits limits,
                          const std::function<std::string()>& read) {
    if (limits.memory == 0) limits.memory = available_memory() / 4 * 3;
    std::string answer;
    try {
        answer = in_child(
            [&]() -> std::string {
                try {
                    return 'm' + read();
                } catch (const Error& e) {
                    return 'e' + std::string(e.what());
                }
            },
            limits);
    } catch (const std::runtime_error& e) {
        FilePlace{path}.fail("cannot be read as a mesh: the reader of " + extension + " files " + e.what());
    }
    if (answer.front() == 'e') throw Error(ExitCode::invalid_scene, answer.substr(1));
    return answer.substr(1);
}

MeshDraft import_unguarded(const fs::path& path, const std::string& extension) {
    Assimp::Importer importer;
    const aiScene& scene = open_scene(importer, path, extension);
    MeshDraft draft;
    append(scene, *scene.mRootNode, Eigen::Matrix4d::Identity(), FilePlace{path}, draft);
    if (extension == ".stl") join_equal_positions(draft);
    const auto missing = [](const std::array<double, 2>& uv) { return std::isnan(uv[0]); };
    if (std::all_of(draft.uv.begin(), draft.uv.end(), missing)) draft.uv.clear();
    if (scene.mNumAnimations > 0)
        draft.notes.push_back(plural(scene.mNumAnimations, "animation") +
                              " ignored: the mesh stands still, where its nodes are at rest");
    return draft;
}

MeshDraft import_by_assimp(const fs::path& path, const std::string& extension, ChildLimits limits) {
    if (extension.size() < 2 || !Assimp::Importer().IsExtensionSupported(extension)) {
        FilePlace{path}.fail("\"" + extension +
                             "\" is no format of a mesh that can be read; OBJ, PLY, STL and glTF are some");
    }
    return draft_of(
        read_in_child(path, extension, limits, [&] { return bytes_of(import_unguarded(path, extension)); }));
}

}  // namespace cloth::pipeline
