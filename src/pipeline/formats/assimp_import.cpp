#include "pipeline/formats/assimp_import.h"

#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <map>
#include <utility>

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

/// Appends the meshes of a node and of those below it, moved to where the nodes stand.
void append(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& parent, const FilePlace& place,
            MeshDraft& draft) {
    Eigen::Matrix4d local;
    for (unsigned r = 0; r < 4; ++r) {
        for (unsigned c = 0; c < 4; ++c) local(r, c) = node.mTransformation[r][c];
    }
    const Eigen::Matrix4d world = parent * local;
    const bool moved = !world.isIdentity(0.0);
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
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices != 3) {
                place.fail_polygon(draft.triangles.size(), face.mNumIndices);
            }
            draft.triangles.push_back(
                {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
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
    for (auto& triangle : draft.triangles) {
        for (auto& v : triangle) v = joined[static_cast<std::size_t>(v)];
    }
}

}  // namespace

MeshDraft import_by_assimp(const fs::path& path, const std::string& extension) {
    const FilePlace place{path};
    Assimp::Importer importer;
    if (!importer.IsExtensionSupported(extension)) {
        place.fail("\"" + extension +
                   "\" is no format of a mesh that can be read; OBJ, PLY, STL and glTF are some");
    }
    const aiScene* scene = importer.ReadFile(path.string(), 0);
    if (scene == nullptr || scene->mRootNode == nullptr) {
        place.fail(std::string("cannot be read as a mesh: ") + importer.GetErrorString());
    }
    MeshDraft draft;
    append(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), place, draft);
    if (extension == ".stl") join_equal_positions(draft);
    return draft;
}

}  // namespace cloth::pipeline
