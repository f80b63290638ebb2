#include "pipeline/formats/usda.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <cctype>
#include <cstdint>
#include <deque>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/portable_math.h"
#include "base/text.h"
#include "pipeline/formats/file_io.h"
#include "sim/geometry/vertex_normals.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// "[(x, y, z), …]", numbers as floats with the digits that give the same ones.
template <class Matrix>
std::string rows_text(const Matrix& rows) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    text.push_back('[');
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        text.append(std::string_view(i == 0 ? "(" : ", ("));
        for (Eigen::Index k = 0; k < rows.cols(); ++k) {
            if (k > 0) text.append(std::string_view(", "));
            fmt::format_to(out, FMT_COMPILE("{}"), static_cast<float>(rows(i, k)));
        }
        text.push_back(')');
    }
    text.push_back(']');
    return fmt::to_string(text);
}

std::string matrix_text(const Placement& p) {
    // Points are rows there: p' = (p, 1) M.
    const Mat3& R = p.rotation;
    const Vec3& t = p.translation;
    return fmt::format("( ({}, {}, {}, 0), ({}, {}, {}, 0), ({}, {}, {}, 0), ({}, {}, {}, 1) )", R(0, 0),
                       R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), R(0, 2), R(1, 2), R(2, 2), t.x(), t.y(),
                       t.z());
}

/// What a frame gives an attribute, frame by frame; one value where all are the same.
class Samples {
  public:
    void add(std::int64_t frame, const std::string& value) {
        if (all_.empty()) first_ = value;
        same_ = same_ && value == first_;
        all_ += fmt::format("            {}: {},\n", frame, value);
    }
    std::string text(const std::string& attribute) const {
        return same_ ? fmt::format("        {} = {}\n", attribute, first_)
                     : fmt::format("        {}.timeSamples = {{\n{}        }}\n", attribute, all_);
    }

  private:
    std::string all_, first_;
    bool same_ = true;
};

std::string box_of(const Points& positions) {
    Eigen::Matrix<double, 2, 3> corners;
    corners << positions.colwise().minCoeff(), positions.colwise().maxCoeff();
    return rows_text(corners);
}

/// Of a mesh that bends. They wait in files of their own, as a file has one attribute behind the other.
struct BendingSamples {
    explicit BendingSamples(const fs::path& file) : points(file), normals(file) {}
    GrowingFile points, normals;
    Samples extent;

    void add(std::int64_t frame, const Points& all_points, const Points& all_normals) {
        points.write(fmt::format("            {}: {},\n", frame, rows_text(all_points)));
        normals.write(fmt::format("            {}: {},\n", frame, rows_text(all_normals)));
        extent.add(frame, box_of(all_points));
    }
};

constexpr const char* by_vertex = " (\n            interpolation = \"vertex\"\n        )\n";

/// Letters, digits and underscores, no digit first, each but once.
class PrimNames {
  public:
    std::string of(const std::string& name) {
        std::string text;
        for (const char c : name) text += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
        if (text.empty() || std::isdigit(static_cast<unsigned char>(text[0])) != 0) text = "_" + text;
        while (!taken_.insert(text).second) text += "_";
        return text;
    }

  private:
    std::set<std::string> taken_{"Materials", "camera"};
};

class Usda : public Exporter {
  public:
    explicit Usda(fs::path file) : path_(std::move(file)) {}

    void begin(const ExportScene& scene) override {
        scene_ = &scene;
        file_.emplace(path_);
        for (std::size_t c = 0; c < scene.topology.cloths.size(); ++c) sheets_.emplace_back(path_);
        for (const ExportCollider& collider : scene.colliders) {
            bodies_.emplace_back();
            if (collider.bends) bodies_.back().bending.emplace(path_);
        }
    }
    void frame(const ExportFrame& frame) override {
        for (std::size_t c = 0; c < sheets_.size(); ++c) {
            const ClothRange& cloth = scene_->topology.cloths[c];
            const Points positions = frame.positions.middleRows(cloth.first_vertex, cloth.vertex_count);
            sheets_[c].add(frame.index, positions, vertex_normals(positions, scene_->triangles_of(cloth)));
        }
        for (std::size_t c = 0; c < bodies_.size(); ++c) {
            const auto& bent = frame.colliders[c].bent;
            if (bent) bodies_[c].bending->add(frame.index, bent->positions, bent->normals);
            bodies_[c].transform.add(frame.index, matrix_text(frame.colliders[c].placement));
            bodies_[c].visibility.add(frame.index, frame.colliders[c].on ? "\"inherited\"" : "\"invisible\"");
        }
        const ExportCamera& camera = frame.camera;
        Placement stands;
        stands.rotation = camera.axes();
        stands.translation = camera.position;
        camera_.add(frame.index, matrix_text(stands));
        focal_length_.add(frame.index,
                          fmt::format("{}", 0.5 * aperture / tan_degrees(0.5 * camera.field_of_view)));
    }
    void end() override {
        const double rate = scene_->frame_rate;
        file_->write(fmt::format(
            "#usda 1.0\n(\n    defaultPrim = \"World\"\n    upAxis = \"Y\"\n    metersPerUnit = 1\n"
            "    startTimeCode = {}\n    endTimeCode = {}\n    timeCodesPerSecond = {}\n    framesPerSecond "
            "= {}\n)\n\n"
            "def Xform \"World\"\n{{\n",
            scene_->frames.front(), scene_->frames.back(), rate, rate));
        std::string materials;
        PrimNames names;
        for (std::size_t c = 0; c < sheets_.size(); ++c) {
            const ClothRange& cloth = scene_->topology.cloths[c];
            const std::string name = names.of(cloth.name);
            begin_mesh(name, scene_->triangles_of(cloth), true);
            put_samples(sheets_[c]);
            file_->write("        texCoord2f[] primvars:st = " +
                         rows_text(scene_->uv.middleRows(cloth.first_vertex, cloth.vertex_count)) +
                         by_vertex + "    }\n\n");
            materials += material(name, scene_->materials.at(c));
        }
        for (std::size_t c = 0; c < bodies_.size(); ++c) {
            const ExportCollider& collider = scene_->colliders[c];
            const std::string name = names.of(collider.name);
            begin_mesh(name, collider.surface.triangles, false);
            if (bodies_[c].bending) {
                put_samples(*bodies_[c].bending);
            } else {
                file_->write("        float3[] extent = " + box_of(collider.surface.positions) +
                             "\n        point3f[] points = " + rows_text(collider.surface.positions) +
                             "\n        normal3f[] normals = " + rows_text(collider.surface.normals) +
                             by_vertex);
            }
            file_->write(bodies_[c].visibility.text("token visibility") +
                         bodies_[c].transform.text("matrix4d xformOp:transform") +
                         "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n\n");
            materials += material(name, collider.material);
        }
        file_->write(
            fmt::format("    def Camera \"camera\"\n    {{\n        float horizontalAperture = {}\n"
                        "        float verticalAperture = {}\n        float2 clippingRange = (0.01, 10000)\n",
                        aperture * scene_->aspect, aperture) +
            focal_length_.text("float focalLength") + camera_.text("matrix4d xformOp:transform") +
            "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n\n    def Scope "
            "\"Materials\"\n    {\n" +
            materials + "    }\n}\n");
        file_->finish();
    }

  private:
    static constexpr double aperture = 20.0;  ///< height of the camera's film [mm]; only its ratio counts

    void put_samples(BendingSamples& samples) {
        file_->write(samples.extent.text("float3[] extent") + "        point3f[] points.timeSamples = {\n");
        file_->write(std::move(samples.points));
        file_->write(std::string("        }\n        normal3f[] normals") + by_vertex +
                     "        normal3f[] normals.timeSamples = {\n");
        file_->write(std::move(samples.normals));
        file_->write("        }\n");
    }
    void begin_mesh(const std::string& name, const Triangles& triangles, bool sheet) {
        fmt::memory_buffer text;
        const auto out = std::back_inserter(text);
        fmt::format_to(
            out,
            "    def Mesh \"{}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{\n"
            "        uniform token subdivisionScheme = \"none\"\n        uniform bool doubleSided = {}\n"
            "        rel material:binding = </World/Materials/{}>\n        int[] faceVertexCounts = [",
            name, sheet ? 1 : 0, name);
        for (Eigen::Index t = 0; t < triangles.rows(); ++t)
            text.append(std::string_view(t == 0 ? "3" : ", 3"));
        text.append(std::string_view("]\n        int[] faceVertexIndices = ["));
        for (Eigen::Index i = 0; i < triangles.size(); ++i) {
            if (i > 0) text.append(std::string_view(", "));
            fmt::format_to(out, FMT_COMPILE("{}"), triangles.data()[i]);
        }
        text.append(std::string_view("]\n"));
        file_->write(fmt::to_string(text));
    }
    static std::string material(const std::string& name, const render::Material& m) {
        return fmt::format(
            "        def Material \"{0}\"\n        {{\n            token outputs:surface.connect = "
            "</World/Materials/{0}/surface.outputs:surface>\n\n            def Shader \"surface\"\n          "
            "  {{\n"
            "                uniform token info:id = \"UsdPreviewSurface\"\n"
            "                color3f inputs:diffuseColor = ({1}, {2}, {3})\n"
            "                float inputs:roughness = {4}\n                token outputs:surface\n           "
            " }}\n"
            "        }}\n",
            name, m.front[0], m.front[1], m.front[2], m.roughness);
    }

    struct Body {
        Samples transform, visibility;
        std::optional<BendingSamples> bending;
    };
    const ExportScene* scene_ = nullptr;
    fs::path path_;
    std::optional<GrowingFile> file_;
    std::deque<BendingSamples> sheets_;
    std::deque<Body> bodies_;
    Samples camera_, focal_length_;
};

}  // namespace

std::unique_ptr<Exporter> usda_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<Usda>(file);
}

}  // namespace cloth::pipeline
