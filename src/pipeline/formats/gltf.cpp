#include "pipeline/formats/gltf.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/raw_bytes.h"
#include "render/image/image.h"
#include "sim/geometry/vertex_normals.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::uint64_t glb_limit = std::numeric_limits<std::uint32_t>::max();
enum Component { u32 = 5125, f32 = 5126 };
enum Target { none = 0, vertices = 34962, corners = 34963 };

/// The numbers of a file, and what is told of them.
class Buffer {
  public:
    explicit Buffer(const fs::path& file) : bytes_(file) {}

    /// The number of a new view of these bytes.
    std::size_t view(const std::string& bytes, Target target = none) {
        json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
        if (target != none) view["target"] = target;
        views.push_back(std::move(view));
        bytes_.write(bytes);
        if (bytes.size() % 4 != 0) bytes_.write(std::string(4 - bytes.size() % 4, '\0'));
        return views.size() - 1;
    }
    /// The number of a new accessor of a matrix's rows; `bounds`: whether it tells the least and greatest.
    template <class Matrix>
    std::size_t floats(const char* type, const Matrix& rows, bool bounds, Target target = none) {
        std::string bytes;
        put_all<float>(bytes, rows);
        json accessor = {{"bufferView", view(bytes, target)},
                         {"componentType", f32},
                         {"count", rows.rows()},
                         {"type", type}};
        for (Eigen::Index k = 0; bounds && k < rows.cols(); ++k) {
            accessor["min"].push_back(static_cast<float>(rows.col(k).minCoeff()));
            accessor["max"].push_back(static_cast<float>(rows.col(k).maxCoeff()));
        }
        return add(std::move(accessor));
    }
    std::size_t indices(const Triangles& triangles) {
        std::string bytes;
        put_all<std::uint32_t>(bytes, triangles);
        return add({{"bufferView", view(bytes, corners)},
                    {"componentType", u32},
                    {"count", triangles.size()},
                    {"type", "SCALAR"}});
    }
    /// Of scalars in the order of their memory.
    std::size_t scalars(const std::vector<float>& values, bool bounds) {
        return floats(
            "SCALAR",
            Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Eigen::Index>(values.size())),
            bounds);
    }
    GrowingFile& bytes() { return bytes_; }

    json views = json::array(), accessors = json::array();

  private:
    std::size_t add(json accessor) {
        accessors.push_back(std::move(accessor));
        return accessors.size() - 1;
    }
    GrowingFile bytes_;
};

/// How a node stands in each frame.
struct Track {
    std::size_t node;
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> translation, scale;
    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> rotation;  ///< x y z w

    Track(std::size_t moved, std::size_t frames)
        : node(moved), translation(frames, 3), scale(frames, 3), rotation(frames, 4) {}
    void set(Eigen::Index frame, const Vec3& t, const Mat3& R, double s) {
        Eigen::Quaterniond q(R);
        q.normalize();
        if (frame > 0 && rotation.row(frame - 1).dot(q.coeffs().transpose()) < 0.0) q.coeffs() *= -1.0;
        translation.row(frame) = t.transpose();
        rotation.row(frame) = q.coeffs().transpose();
        scale.row(frame).setConstant(s);
    }
};

class Gltf : public Exporter {
  public:
    explicit Gltf(fs::path file) : path_(std::move(file)), binary_(extension_of(path_) != ".gltf") {}

    void begin(const ExportScene& scene) override {
        scene_ = &scene;
        const double frames = static_cast<double>(scene.frames.size()),
                     n = scene.vertex_count() + bending_vertices(scene);
        require_room(n * 8.0 + 24.0 * n * frames + 12.0 * scene.triangle_count() + 4.0 * frames * frames);
        buffer_.emplace(binary_ ? path_ : bin());
    }
    void frame(const ExportFrame& frame) override {
        if (done_ == 0) {
            for (std::size_t c = 0; c < scene_->topology.cloths.size(); ++c) first(c, frame);
            for (std::size_t c = 0; c < scene_->colliders.size(); ++c) {
                const ExportCollider& collider = scene_->colliders[c];
                const auto& bent = frame.colliders.at(c).bent;
                const Surface& surface = bent ? *bent : collider.surface;
                if (bent) {
                    add_bending(collider.name, surface.positions, surface.normals, {}, surface.triangles,
                                collider.material);
                } else {
                    add_mesh(collider.name, surface.positions, surface.normals, {}, surface.triangles,
                             collider.material);
                }
                tracks_.emplace_back(nodes_.size() - 1, scene_->frames.size());
            }
            add_camera(frame.camera);
        } else {
            later(frame);
        }
        for (std::size_t c = 0; c < scene_->colliders.size(); ++c) {
            const ColliderPose& pose = frame.colliders.at(c);
            tracks_[c].set(done_, pose.placement.translation, pose.placement.rotation, pose.on ? 1.0 : 0.0);
        }
        tracks_.back().set(done_, frame.camera.position, frame.camera.axes(), 1.0);
        ++done_;
    }
    void end() override {
        animate();
        json scene_nodes = json::array();
        for (std::size_t i = 0; i < nodes_.size(); ++i) scene_nodes.push_back(i);
        json root = {{"asset", {{"version", "2.0"}, {"generator", "render_cloth " + program_version()}}},
                     {"scene", 0},
                     {"scenes", {{{"name", scene_->name}, {"nodes", scene_nodes}}}},
                     {"nodes", nodes_},
                     {"meshes", meshes_},
                     {"materials", materials_},
                     {"cameras", cameras_},
                     {"accessors", buffer_->accessors},
                     {"bufferViews", buffer_->views},
                     {"buffers", {{{"byteLength", buffer_->bytes().size()}}}}};
        if (!channels_.empty())
            root["animations"] = {{{"name", scene_->name}, {"samplers", samplers_}, {"channels", channels_}}};
        if (!images_.empty()) {
            root["images"] = images_;
            root["textures"] = textures_;
        }
        if (binary_) {
            finish_binary(root.dump());
        } else {
            root["buffers"][0]["uri"] = bin().filename().string();
            GrowingFile text(path_);
            text.write(root.dump(1, '\t'));
            buffer_->bytes().finish();
            text.finish();
        }
    }

  private:
    fs::path bin() const { return fs::path(path_).replace_extension(".bin"); }

    static double bending_vertices(const ExportScene& scene) {
        double sum = 0.0;
        for (const ExportCollider& collider : scene.colliders)
            if (collider.bends) sum += static_cast<double>(collider.surface.positions.rows());
        return sum;
    }
    void require_room(double bytes) const {
        if (binary_ && bytes > static_cast<double>(glb_limit) - 1e6)
            throw Error(ExitCode::usage,
                        fmt::format("--file {}: these {} frames take {}, and a .glb holds 4.3 GB; "
                                    "name a .gltf, which holds any size, or fewer --frames",
                                    path_.string(), scene_->frames.size(), memory_text(bytes)));
    }

    /// A node with a mesh; returns its primitive.
    json& add_mesh(const std::string& name, const Points& positions, const Points& normals,
                   const TexturePoints& uv, const Triangles& triangles, const render::Material& material) {
        json attributes = {{"POSITION", buffer_->floats("VEC3", positions, true, vertices)},
                           {"NORMAL", buffer_->floats("VEC3", normals, false, vertices)}};
        if (uv.rows() > 0) attributes["TEXCOORD_0"] = buffer_->floats("VEC2", uv, false, vertices);
        nodes_.push_back({{"name", name}, {"mesh", meshes_.size()}});
        meshes_.push_back({{"name", name},
                           {"primitives",
                            {{{"attributes", attributes},
                              {"indices", buffer_->indices(triangles)},
                              {"material", add_material(name, material, uv.rows() > 0)}}}}});
        return meshes_.back()["primitives"][0];
    }
    std::size_t add_material(const std::string& name, const render::Material& m, bool sheet) {
        json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", m.roughness}};
        if (m.pattern == render::Pattern::image && m.image) {
            const std::vector<std::uint8_t> png = render::encode_png(*m.image);
            images_.push_back({{"bufferView", buffer_->view(std::string(png.begin(), png.end()))},
                               {"mimeType", "image/png"}});
            textures_.push_back({{"source", images_.size() - 1}});
            pbr["baseColorTexture"] = {{"index", textures_.size() - 1}};
        } else {
            pbr["baseColorFactor"] = {m.front[0], m.front[1], m.front[2], 1.0};
        }
        materials_.push_back({{"name", name}, {"pbrMetallicRoughness", pbr}, {"doubleSided", sheet}});
        return materials_.size() - 1;
    }

    /// A mesh whose later frames are to be told, too.
    void add_bending(const std::string& name, const Points& positions, const Points& normals,
                     const TexturePoints& uv, const Triangles& triangles, const render::Material& material) {
        add_mesh(name, positions, normals, uv, triangles, material);
        bending_.push_back({nodes_.size() - 1, positions.cast<float>().cast<double>(),
                            normals.cast<float>().cast<double>()});
    }
    void first(std::size_t c, const ExportFrame& frame) {
        const ClothRange& cloth = scene_->topology.cloths[c];
        const Points positions = frame.positions.middleRows(cloth.first_vertex, cloth.vertex_count);
        const Triangles triangles = scene_->triangles_of(cloth);
        TexturePoints uv = scene_->uv.middleRows(cloth.first_vertex, cloth.vertex_count);
        uv.col(1) = 1.0 - uv.col(1).array();  // downwards here
        add_bending(cloth.name, positions, vertex_normals(positions, triangles), uv, triangles,
                    scene_->materials.at(c));
    }
    /// What has changed since the first frame, of cloths and then of colliders that bend.
    void later(const ExportFrame& frame) {
        std::size_t next = 0;
        for (const ClothRange& cloth : scene_->topology.cloths) {
            const Points positions = frame.positions.middleRows(cloth.first_vertex, cloth.vertex_count);
            add_target(bending_[next++], frame.index, positions,
                       vertex_normals(positions, scene_->triangles_of(cloth)));
        }
        for (const ColliderPose& pose : frame.colliders)
            if (pose.bent)
                add_target(bending_[next++], frame.index, pose.bent->positions, pose.bent->normals);
    }

    /// A mesh as the first frame has it, in floats.
    struct Bending {
        std::size_t node;
        Points positions, normals;
    };
    void add_target(const Bending& base, std::int64_t index, const Points& positions, const Points& normals) {
        json& mesh = meshes_[nodes_[base.node]["mesh"].get<std::size_t>()];
        mesh["primitives"][0]["targets"].push_back(
            {{"POSITION", buffer_->floats("VEC3", Points(positions - base.positions), true, vertices)},
             {"NORMAL", buffer_->floats("VEC3", Points(normals - base.normals), false, vertices)}});
        mesh["weights"].push_back(0.0);
        mesh["extras"]["targetNames"].push_back(fmt::format("frame_{:06d}", index));
    }

    void add_camera(const ExportCamera& camera) {
        cameras_.push_back({{"type", "perspective"},
                            {"perspective",
                             {{"yfov", camera.field_of_view * std::numbers::pi / 180.0},
                              {"aspectRatio", scene_->aspect},
                              {"znear", 0.01}}}});
        nodes_.push_back({{"name", "camera"}, {"camera", 0}});
        tracks_.emplace_back(nodes_.size() - 1, scene_->frames.size());
    }

    void channel(std::size_t node, const char* path, std::size_t times, std::size_t values, const char* how) {
        samplers_.push_back({{"input", times}, {"output", values}, {"interpolation", how}});
        channels_.push_back(
            {{"sampler", samplers_.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
    }
    /// Where nodes stand, and the way that they go.
    void animate() {
        const auto count = static_cast<std::size_t>(done_);
        std::size_t times = 0;
        if (count > 1) {
            std::vector<float> seconds, weights(count * (count - 1), 0.0f);
            for (std::size_t i = 0; i < count; ++i)
                seconds.push_back(static_cast<float>(scene_->time(scene_->frames[i])));
            for (std::size_t i = 1; i < count; ++i) weights[i * (count - 1) + i - 1] = 1.0f;
            times = buffer_->scalars(seconds, true);
            const std::size_t values = buffer_->scalars(weights, false);
            for (const Bending& mesh : bending_) channel(mesh.node, "weights", times, values, "LINEAR");
        }
        for (const Track& track : tracks_) {
            const auto part = [&](const char* path, const char* type, const auto& rows, const auto& usual,
                                  const char* how) {
                const bool moves = count > 1 && !(rows.rowwise() - rows.row(0)).isZero(0.0);
                if (moves) channel(track.node, path, times, buffer_->floats(type, rows, false), how);
                if (moves || rows.row(0) == usual) return;
                for (Eigen::Index k = 0; k < rows.cols(); ++k) nodes_[track.node][path].push_back(rows(0, k));
            };
            part("translation", "VEC3", track.translation, Eigen::RowVector3d(0.0, 0.0, 0.0), "LINEAR");
            part("rotation", "VEC4", track.rotation, Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0), "LINEAR");
            part("scale", "VEC3", track.scale, Eigen::RowVector3d(1.0, 1.0, 1.0), "STEP");
        }
    }

    void finish_binary(std::string text) {
        text.append((4 - text.size() % 4) % 4, ' ');
        const std::uint64_t bin = buffer_->bytes().size(), total = 12 + 8 + text.size() + 8 + bin;
        require_room(static_cast<double>(total));
        std::string head = "glTF";
        put(head, std::uint32_t{2});
        put(head, static_cast<std::uint32_t>(total));
        put(head, static_cast<std::uint32_t>(text.size()));
        head += "JSON" + text;
        put(head, static_cast<std::uint32_t>(bin));
        head += std::string("BIN\0", 4);
        GrowingFile file(path_);
        file.write(head);
        file.write(std::move(buffer_->bytes()));
        file.finish();
    }

    const ExportScene* scene_ = nullptr;
    fs::path path_;
    bool binary_;
    Eigen::Index done_ = 0;  ///< frames so far
    std::optional<Buffer> buffer_;
    std::vector<Bending> bending_;  ///< the cloths, then the colliders that bend
    std::vector<Track> tracks_;     ///< of the colliders, then of the camera
    json nodes_ = json::array(), meshes_ = json::array(), materials_ = json::array(),
         cameras_ = json::array(), images_ = json::array(), textures_ = json::array(),
         samplers_ = json::array(), channels_ = json::array();
};

}  // namespace

std::unique_ptr<Exporter> gltf_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<Gltf>(file);
}

}  // namespace cloth::pipeline
