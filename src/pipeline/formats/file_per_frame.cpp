#include "pipeline/formats/file_per_frame.h"

#include <fmt/format.h>

#include <utility>

#include "pipeline/formats/file_io.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

class FilePerFrame : public Exporter {
  public:
    FilePerFrame(MeshBytes bytes, fs::path file, FrameNames names)
        : bytes_(bytes), file_(std::move(file)), names_(names) {}

    void begin(const Topology& topology, double /*frame_rate*/) override {
        mesh_.triangles = topology.triangles;
    }
    void frame(std::int64_t index, double /*time*/, const Points& positions) override {
        mesh_.positions = positions;
        files_.write(names_ == FrameNames::numbered ? numbered_file(file_, index) : file_, bytes_(mesh_));
    }
    void end() override { files_.finish(); }

  private:
    MeshBytes bytes_;
    fs::path file_;
    FrameNames names_;
    MeshData mesh_;
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
