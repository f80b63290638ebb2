#include "pipeline/formats/vtk.h"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/raw_bytes.h"
#include "sim/geometry/vertex_normals.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr const char* head =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
    "header_type=\"UInt64\">\n";

/// A .vtp: what the file tells of its arrays, and behind that their bytes as they are.
class PolyData {
  public:
    void open(const std::string& element) { text_ += "<" + element + ">\n"; }
    void close(const std::string& element) { text_ += "</" + element + ">\n"; }
    template <class T, class Matrix>
    void array(std::string_view name, const char* type, const Matrix& rows, std::string_view more = "") {
        text_ += fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} format=\"appended\" "
            "offset=\"{}\"/>\n",
            type, name, rows.cols(), more, bytes_.size());
        put(bytes_, static_cast<std::uint64_t>(rows.size()) * sizeof(T));
        put_all<T>(bytes_, rows);
    }
    std::string file() const {
        return fmt::format(fmt::runtime(head), "PolyData") + text_ + "<AppendedData encoding=\"raw\">\n_" +
               bytes_ + "\n</AppendedData>\n</VTKFile>\n";
    }

  private:
    std::string text_, bytes_;
};

using Column = Eigen::VectorXd;

/// Time, points, triangles, and the number of each triangle's object; `point_data` puts in the rest.
template <class PointData>
std::string poly_data(std::optional<double> time, const Points& positions, const Triangles& triangles,
                      const Eigen::VectorXi& objects, const PointData& point_data) {
    PolyData vtp;
    vtp.open("PolyData");
    if (time) {
        vtp.open("FieldData");
        vtp.array<double>("TimeValue", "Float64", Column::Constant(1, *time), " NumberOfTuples=\"1\"");
        vtp.close("FieldData");
    }
    vtp.open(
        fmt::format("Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
                    "NumberOfStrips=\"0\" NumberOfPolys=\"{}\"",
                    positions.rows(), triangles.rows()));
    vtp.open("PointData Normals=\"normal\" TCoords=\"uv\"");
    point_data(vtp);
    vtp.close("PointData");
    vtp.open("CellData Scalars=\"object\"");
    vtp.array<std::int32_t>("object", "Int32", objects);
    vtp.close("CellData");
    vtp.open("Points");
    vtp.array<double>("Points", "Float64", positions);
    vtp.close("Points");
    vtp.open("Polys");
    const Eigen::Map<const Eigen::VectorXi> corners(triangles.data(), triangles.size());
    vtp.array<std::int32_t>("connectivity", "Int32", corners);
    vtp.array<std::int32_t>(
        "offsets", "Int32",
        Eigen::VectorXi::LinSpaced(triangles.rows(), 3, static_cast<int>(triangles.size())));
    vtp.close("Polys");
    vtp.close("Piece");
    vtp.close("PolyData");
    return vtp.file();
}

/// Colliders that are on, all as one mesh; without a time, as many frames may share it.
std::string colliders_file(const ExportScene& scene, const ExportFrame& frame) {
    Eigen::Index n = 0, m = 0;
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        if (!frame.colliders[c].on) continue;
        n += scene.colliders[c].surface.positions.rows();
        m += scene.colliders[c].surface.triangles.rows();
    }
    Points positions(n, 3), normals(n, 3);
    Triangles triangles(m, 3);
    Eigen::VectorXi objects(m);
    n = m = 0;
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        const auto& [on, placement, bent] = frame.colliders[c];
        if (!on) continue;
        const Surface& surface = bent ? *bent : scene.colliders[c].surface;
        const Eigen::Index own = surface.positions.rows(), faces = surface.triangles.rows();
        positions.middleRows(n, own) = (surface.positions * placement.rotation.transpose()).rowwise() +
                                       placement.translation.transpose();
        normals.middleRows(n, own) = surface.normals * placement.rotation.transpose();
        triangles.middleRows(m, faces) = surface.triangles.array() + static_cast<int>(n);
        objects.segment(m, faces).setConstant(static_cast<int>(c));
        n += own;
        m += faces;
    }
    return poly_data({}, positions, triangles, objects,
                     [&](PolyData& vtp) { vtp.array<float>("normal", "Float32", normals); });
}

class Vtk : public Exporter {
  public:
    Vtk(fs::path file, FrameNames names)
        : file_(std::move(file)), alone_(names == FrameNames::as_given && extension_of(file_) != ".pvd") {}

    void begin(const ExportScene& scene) override {
        scene_ = &scene;
        objects_.resize(scene.triangle_count());
        for (std::size_t c = 0; c < scene.topology.cloths.size(); ++c) {
            const ClothRange& cloth = scene.topology.cloths[c];
            objects_.segment(cloth.first_triangle, cloth.triangle_count).setConstant(static_cast<int>(c));
        }
    }
    void frame(const ExportFrame& frame) override {
        const Triangles& triangles = scene_->topology.triangles;
        const auto point_data = [&](PolyData& vtp) {
            for (const VertexFieldName& field : scene_->fields)
                vtp.array<float>(column_name(field), "Float32", frame.field(field.field));
            vtp.array<float>("velocity", "Float32", frame.velocities);
            vtp.array<float>("normal", "Float32", vertex_normals(frame.positions, triangles));
            vtp.array<float>("uv", "Float32", scene_->uv);
        };
        const std::string bytes = poly_data(frame.time, frame.positions, triangles, objects_, point_data);
        if (alone_) return files_.write(file_, bytes);
        const fs::path cloths = name("", frame.index);
        files_.write(cloths, bytes);
        tell(frame.time, 0, cloths);
        if (scene_->colliders.empty()) return;
        if (const std::string poses = poses_of(frame); poses != poses_) {
            poses_ = poses;
            colliders_ = name("_colliders", frame.index);
            files_.write(colliders_, colliders_file(*scene_, frame));
        }
        tell(frame.time, 1, colliders_);
    }
    void end() override {
        if (!alone_)
            files_.write(fs::path(file_).replace_extension(".pvd"),
                         fmt::format(fmt::runtime(head), "Collection") + "<Collection>\n" + list_ +
                             "</Collection>\n</VTKFile>\n");
        files_.finish();
    }

  private:
    /// In ParaView a column is what people call it.
    static std::string column_name(const VertexFieldName& field) {
        return field.field == VertexField::bending ? "curvature" : field.name;
    }
    fs::path name(const std::string& what, std::int64_t frame) const {
        return numbered_file(file_.parent_path() / (file_.stem().string() + what + ".vtp"), frame);
    }
    void tell(double time, int part, const fs::path& file) {
        list_ += fmt::format("<DataSet timestep=\"{:.17g}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", time,
                             part, escaped(file.filename().string()));
    }
    /// What decides where the colliders are.
    static std::string poses_of(const ExportFrame& frame) {
        std::string bytes;
        for (const ColliderPose& pose : frame.colliders) {
            put(bytes, pose.on);
            put_all<double>(bytes, pose.placement.rotation);
            put_all<double>(bytes, pose.placement.translation);
            if (pose.bent) put_all<double>(bytes, pose.bent->positions);
        }
        return bytes;
    }

    const ExportScene* scene_ = nullptr;
    fs::path file_;
    bool alone_;
    Eigen::VectorXi objects_;
    FileSet files_;
    std::string list_;      ///< of the .pvd
    std::string poses_;     ///< of the colliders in
    fs::path colliders_{};  ///< this file
};

}  // namespace

std::unique_ptr<Exporter> vtk_exporter(const fs::path& file, FrameNames names) {
    return std::make_unique<Vtk>(file, names);
}

}  // namespace cloth::pipeline
