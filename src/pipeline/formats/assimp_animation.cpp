#include "pipeline/formats/assimp_animation.h"

#include <assimp/anim.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/assimp_import.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix4d;

constexpr double samples_per_second = 60.0;

Vec3 vector_of(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}
Eigen::Quaterniond quaternion_of(const aiQuaternion& q) {
    return Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

/// Between keys a and b of a channel.
struct Between {
    unsigned a, b;
    double share;  ///< of b
};
template <class Key>
Between between(const Key* keys, unsigned count, double ticks) {
    unsigned next = 0;
    while (next < count && keys[next].mTime <= ticks) ++next;
    if (next == 0) return {0, 0, 0.0};
    if (next == count) return {count - 1, count - 1, 0.0};
    const double begin = keys[next - 1].mTime;
    return {next - 1, next, (ticks - begin) / (keys[next].mTime - begin)};
}

Vec3 mixed(const aiVectorKey* keys, unsigned count, double ticks) {
    const auto [a, b, share] = between(keys, count, ticks);
    return (1.0 - share) * vector_of(keys[a].mValue) + share * vector_of(keys[b].mValue);
}

/// A node's own transform at a time.
Matrix4d transform_at(const aiNodeAnim& channel, double ticks) {
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (channel.mNumPositionKeys > 0)
        transform.translate(mixed(channel.mPositionKeys, channel.mNumPositionKeys, ticks));
    if (channel.mNumRotationKeys > 0) {
        const auto [a, b, share] = between(channel.mRotationKeys, channel.mNumRotationKeys, ticks);
        transform.rotate(quaternion_of(channel.mRotationKeys[a].mValue)
                             .slerp(share, quaternion_of(channel.mRotationKeys[b].mValue)));
    }
    if (channel.mNumScalingKeys > 0)
        transform.scale(mixed(channel.mScalingKeys, channel.mNumScalingKeys, ticks));
    return transform.matrix();
}

class Animated {
  public:
    Animated(const aiScene& scene, const FilePlace& place)
        : scene_(scene), animation_(*scene.mAnimations[0]), place_(place) {
        for (unsigned c = 0; c < animation_.mNumChannels; ++c)
            channels_[animation_.mChannels[c]->mNodeName.C_Str()] = animation_.mChannels[c];
        for (unsigned c = 0; c < animation_.mNumMorphMeshChannels; ++c) {
            // glTF's reader names the node, others the mesh with a number behind it.
            const std::string name = animation_.mMorphMeshChannels[c]->mName.C_Str();
            morphs_[name.substr(0, name.find('*'))] = animation_.mMorphMeshChannels[c];
        }
    }

    double ticks_per_second() const {
        return animation_.mTicksPerSecond > 0.0 ? animation_.mTicksPerSecond : 25.0;
    }
    double seconds() const { return animation_.mDuration / ticks_per_second(); }

    Points positions_at(double time) const {
        const double ticks = time * ticks_per_second();
        std::map<std::string, Matrix4d> global;
        place_nodes(*scene_.mRootNode, Matrix4d::Identity(), ticks, global);
        std::vector<Vec3> points;
        append(*scene_.mRootNode, ticks, global, points);
        Points positions(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            positions.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
        return positions;
    }

  private:
    void place_nodes(const aiNode& node, const Matrix4d& parent, double ticks,
                     std::map<std::string, Matrix4d>& global) const {
        const auto channel = channels_.find(node.mName.C_Str());
        const Matrix4d world = parent * (channel == channels_.end() ? matrix_of(node.mTransformation)
                                                                    : transform_at(*channel->second, ticks));
        global[node.mName.C_Str()] = world;
        for (unsigned i = 0; i < node.mNumChildren; ++i)
            place_nodes(*node.mChildren[i], world, ticks, global);
    }
    void append(const aiNode& node, double ticks, const std::map<std::string, Matrix4d>& global,
                std::vector<Vec3>& points) const {
        for (unsigned i = 0; i < node.mNumMeshes; ++i) {
            const aiMesh& mesh = *scene_.mMeshes[node.mMeshes[i]];
            const std::vector<Vec3> shape = morphed(node, mesh, ticks);
            const std::vector<Matrix4d> by_bones = skin(mesh, global);
            const Matrix4d& world = global.at(node.mName.C_Str());
            for (unsigned v = 0; v < mesh.mNumVertices; ++v)
                points.push_back(
                    ((by_bones.empty() ? world : by_bones[v]) * shape[v].homogeneous()).head<3>());
        }
        for (unsigned i = 0; i < node.mNumChildren; ++i) append(*node.mChildren[i], ticks, global, points);
    }

    /// The mesh with its morph targets mixed in.
    std::vector<Vec3> morphed(const aiNode& node, const aiMesh& mesh, double ticks) const {
        std::vector<Vec3> shape;
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) shape.push_back(vector_of(mesh.mVertices[v]));
        auto found = morphs_.find(node.mName.C_Str());
        if (found == morphs_.end()) found = morphs_.find(mesh.mName.C_Str());
        const std::vector<Vec3> base = shape;
        for (unsigned k = 0; k < mesh.mNumAnimMeshes; ++k) {
            const aiAnimMesh& target = *mesh.mAnimMeshes[k];
            double weight = target.mWeight;
            if (found != morphs_.end()) {
                const aiMeshMorphAnim& keys = *found->second;
                const auto [a, b, share] = between(keys.mKeys, keys.mNumKeys, ticks);
                weight = (1.0 - share) * weight_of(keys.mKeys[a], k) + share * weight_of(keys.mKeys[b], k);
            }
            if (weight == 0.0 || !target.HasPositions()) continue;
            for (unsigned v = 0; v < mesh.mNumVertices; ++v)
                shape[v] += weight * (vector_of(target.mVertices[v]) - base[v]);
        }
        return shape;
    }
    static double weight_of(const aiMeshMorphKey& key, unsigned target) {
        for (unsigned i = 0; i < key.mNumValuesAndWeights; ++i)
            if (key.mValues[i] == target) return key.mWeights[i];
        return 0.0;
    }

    /// What each vertex is moved by; none where the mesh has no bones.
    std::vector<Matrix4d> skin(const aiMesh& mesh, const std::map<std::string, Matrix4d>& global) const {
        std::vector<Matrix4d> moved;
        if (mesh.mNumBones == 0) return moved;
        moved.assign(mesh.mNumVertices, Matrix4d::Zero());
        std::vector<double> sum(mesh.mNumVertices, 0.0);
        for (unsigned b = 0; b < mesh.mNumBones; ++b) {
            const aiBone& bone = *mesh.mBones[b];
            const auto node = global.find(bone.mName.C_Str());
            if (node == global.end())
                place_.fail(
                    fmt::format("the bone {} of mesh {} is no node", bone.mName.C_Str(), mesh.mName.C_Str()));
            const Matrix4d way = node->second * matrix_of(bone.mOffsetMatrix);
            for (unsigned i = 0; i < bone.mNumWeights; ++i) {
                const auto& [vertex, weight] = bone.mWeights[i];
                moved[vertex] += static_cast<double>(weight) * way;
                sum[vertex] += static_cast<double>(weight);
            }
        }
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            if (!(sum[v] > 0.0))
                place_.fail(
                    fmt::format("vertex {} (counted from 0) of mesh {} has no weight at any bone of its "
                                "skeleton",
                                v, mesh.mName.C_Str()));
            moved[v] /= sum[v];
        }
        return moved;
    }

    const aiScene& scene_;
    const aiAnimation& animation_;
    const FilePlace& place_;
    std::map<std::string, const aiNodeAnim*> channels_;
    std::map<std::string, const aiMeshMorphAnim*> morphs_;
};

// ---------------------------------------------------------------- from process to process

/// Frames, vertices, duration, then all coordinates; notes behind them.
std::string sampled(const fs::path& path, const std::string& extension) {
    const FilePlace place{path};
    Assimp::Importer importer;
    const aiScene& scene = open_scene(importer, path, extension);
    if (scene.mNumAnimations == 0)
        place.fail("has no animation; a body that stands still is named by mesh alone");
    const Animated animated(scene, place);
    const double seconds = animated.seconds();
    constexpr double longest = 3600.0;
    if (!(seconds >= 0.0 && seconds <= longest))
        place.fail(fmt::format("its animation lasts {:g} s; must be within an hour", seconds));
    std::vector<double> times;
    const auto whole = static_cast<int>(std::floor(seconds * samples_per_second - 1e-6));
    for (int k = 0; k <= whole; ++k) times.push_back(k / samples_per_second);
    times.push_back(std::max(seconds, times.empty() ? 0.0 : times.back() + 1e-3));
    std::string bytes;
    const auto append = [&](const void* data, std::size_t size) {
        bytes.append(static_cast<const char*>(data), size);
    };
    for (const double time : times) {
        const Points positions = animated.positions_at(time);
        if (bytes.empty()) {
            const std::int64_t sizes[] = {static_cast<std::int64_t>(times.size()), positions.rows()};
            append(sizes, sizeof sizes);
            append(times.data(), times.size() * sizeof(double));
        }
        append(positions.data(), static_cast<std::size_t>(positions.size()) * sizeof(double));
    }
    if (scene.mNumAnimations > 1)
        bytes += fmt::format("has {} animations; the first, {}, is taken", scene.mNumAnimations,
                             one_line(scene.mAnimations[0]->mName.C_Str()));
    return bytes;
}

LoadedCache cache_of(std::string_view bytes) {
    LoadedCache loaded;
    const auto take = [&](void* data, std::size_t size) {
        std::memcpy(data, bytes.data(), size);
        bytes.remove_prefix(size);
    };
    std::int64_t sizes[2];
    take(sizes, sizeof sizes);
    loaded.cache.times.resize(static_cast<std::size_t>(sizes[0]));
    take(loaded.cache.times.data(), loaded.cache.times.size() * sizeof(double));
    for (std::int64_t k = 0; k < sizes[0]; ++k) {
        Points frame(sizes[1], 3);
        take(frame.data(), static_cast<std::size_t>(frame.size()) * sizeof(double));
        loaded.cache.frames.push_back(std::move(frame));
    }
    if (!bytes.empty()) loaded.notes.emplace_back(bytes);
    return loaded;
}

}  // namespace

LoadedCache import_animation(const fs::path& path, const std::string& extension, ChildLimits limits) {
    // The triangles come the way that a mesh that stands still does; this refuses what is no mesh at all.
    LoadedMesh mesh = checked_mesh(import_by_assimp(path, extension, limits), path, true);
    LoadedCache loaded =
        cache_of(read_in_child(path, extension, limits, [&] { return sampled(path, extension); }));
    loaded.cache.triangles = std::move(mesh.mesh.triangles);
    return loaded;
}

}  // namespace cloth::pipeline
