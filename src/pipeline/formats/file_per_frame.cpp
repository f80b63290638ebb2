#include "pipeline/formats/file_per_frame.h"

#include <fmt/format.h>

#include <utility>

#include "pipeline/formats/file_io.h"
#include "sim/geometry/vertex_normals.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

class FilePerFrame : public Exporter {
  public:
    FilePerFrame(MeshBytes bytes, fs::path file, FrameNames names)
        : bytes_(bytes), file_(std::move(file)), names_(names) {}

    void begin(const ExportScene& scene) override { scene_ = &scene; }
    void frame(const ExportFrame& frame) override {
        const Topology& topology = scene_->topology;
        MeshOut mesh(frame.positions, topology.triangles);
        mesh.normals = vertex_normals(frame.positions, topology.triangles);
        mesh.uv = scene_->uv;
        for (const ClothRange& cloth : topology.cloths)
            mesh.objects.push_back({cloth.name, cloth.first_vertex, cloth.vertex_count, cloth.first_triangle,
                                    cloth.triangle_count});
        files_.write(names_ == FrameNames::numbered ? numbered_file(file_, frame.index) : file_,
                     bytes_(mesh));
    }
    void end() override { files_.finish(); }

  private:
    const ExportScene* scene_ = nullptr;
    MeshBytes bytes_;
    fs::path file_;
    FrameNames names_;
    FileSet files_;
};

}  // namespace

fs::path numbered_file(const fs::path& file, std::int64_t frame) {
    return file.parent_path() /
           fmt::format("{}_{:06d}{}", file.stem().string(), frame, file.extension().string());
}

std::unique_ptr<Exporter> file_per_frame(MeshBytes bytes, const fs::path& file, FrameNames names) {
    return std::make_unique<FilePerFrame>(bytes, file, names);
}

}  // namespace cloth::pipeline
