#include "pipeline/formats/npz.h"

#include <fmt/format.h>
#include <minizip/zip.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// Format 1.0: the magic, the length of a Python dictionary, and that, ending at a multiple of 64 bytes.
std::string npy_header(std::string_view type, const std::vector<std::int64_t>& shape) {
    std::string sizes;
    for (const std::int64_t size : shape) sizes += fmt::format("{}, ", size);
    std::string words =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sizes);
    words.append(63 - (10 + words.size()) % 64, ' ');
    words += '\n';
    std::string header("\x93NUMPY\x01\x00", 8);
    put(header, static_cast<std::uint16_t>(words.size()));
    return header + words;
}

/// A zip in the making; its entries are written one behind the other.
class Zip {
  public:
    Zip(const fs::path& path, fs::path target)
        : target_(std::move(target)), zip_(::zipOpen64(path.c_str(), APPEND_STATUS_CREATE)) {
        check(zip_ == nullptr ? ZIP_ERRNO : ZIP_OK);
    }
    Zip(const Zip&) = delete;
    Zip& operator=(const Zip&) = delete;
    ~Zip() {
        if (zip_ != nullptr) ::zipClose(zip_, nullptr);
    }
    void begin(const std::string& name, std::uint64_t size) {
        zip_fileinfo info{};
        info.tmz_date = {.tm_sec = 0, .tm_min = 0, .tm_hour = 0, .tm_mday = 1, .tm_mon = 0, .tm_year = 1980};
        check(::zipOpenNewFileInZip64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, 0, 0,
                                      size >= 0xffff0000u ? 1 : 0));
    }
    void write(std::string_view bytes) {
        constexpr std::size_t most = std::size_t{1} << 30;
        for (; !bytes.empty(); bytes.remove_prefix(std::min(most, bytes.size())))
            check(::zipWriteInFileInZip(zip_, bytes.data(),
                                        static_cast<unsigned>(std::min(most, bytes.size()))));
    }
    void end() { check(::zipCloseFileInZip(zip_)); }
    void close() { check(::zipClose(std::exchange(zip_, nullptr), nullptr)); }

  private:
    void check(int result) const {
        if (result != ZIP_OK)
            throw Error(ExitCode::other,
                        "cannot write " + target_.string() + ": no more can be written to its disk");
    }
    fs::path target_;
    zipFile zip_;
};

class Npz : public Exporter {
  public:
    explicit Npz(fs::path file) : path_(std::move(file)) {}

    void begin(const ExportScene& scene) override {
        scene_ = &scene;
        file_.emplace(path_);
        velocities_.emplace(path_);
        zip_.emplace(file_->part(), path_);
        begin_array("positions", "<f8", motion_shape(), 8);
    }
    void frame(const ExportFrame& frame) override {
        zip_->write(bytes_of(frame.positions));
        velocities_->write(bytes_of(frame.velocities));
    }
    void end() override {
        zip_->end();
        begin_array("velocities", "<f8", motion_shape(), 8);
        std::ifstream waiting(velocities_->part(), std::ios::binary);
        std::string block(std::size_t{1} << 22, '\0');
        for (std::uint64_t left = velocities_->size(); left > 0;) {
            waiting.read(block.data(),
                         static_cast<std::streamsize>(std::min<std::uint64_t>(left, block.size())));
            if (waiting.gcount() <= 0)
                throw Error(ExitCode::other, "cannot read " + velocities_->part().string());
            zip_->write(std::string_view(block).substr(0, static_cast<std::size_t>(waiting.gcount())));
            left -= static_cast<std::uint64_t>(waiting.gcount());
        }
        zip_->end();
        velocities_.reset();
        rest();
        zip_->close();
        file_->finish();
    }

  private:
    std::vector<std::int64_t> motion_shape() const {
        return {static_cast<std::int64_t>(scene_->frames.size()), scene_->vertex_count(), 3};
    }
    static std::string_view bytes_of(const Points& points) {
        return {reinterpret_cast<const char*>(points.data()),
                static_cast<std::size_t>(points.size()) * sizeof(double)};
    }
    void begin_array(const std::string& name, std::string_view type, const std::vector<std::int64_t>& shape,
                     std::uint64_t size_of_one) {
        const std::string header = npy_header(type, shape);
        std::uint64_t size = header.size();
        for (const std::int64_t length : shape) size_of_one *= static_cast<std::uint64_t>(length);
        zip_->begin(name + ".npy", size + size_of_one);
        zip_->write(header);
    }
    void array(const std::string& name, std::string_view type, const std::vector<std::int64_t>& shape,
               const std::string& bytes) {
        begin_array(name, type, shape, 1);
        zip_->write(bytes);
        zip_->end();
    }
    void rest() {
        const Topology& topology = scene_->topology;
        const auto count = static_cast<std::int64_t>(scene_->frames.size());
        std::string times, frames, rate, rest, triangles, uv, names, vertices, corners;
        for (const std::int64_t frame : scene_->frames) {
            put(times, scene_->time(frame));
            put(frames, frame);
        }
        put(rate, scene_->frame_rate);
        put_all<double>(rest, topology.rest_positions);
        put_all<std::int32_t>(triangles, topology.triangles);
        put_all<double>(uv, scene_->uv);
        std::size_t longest = 1;
        for (const ClothRange& cloth : topology.cloths) longest = std::max(longest, cloth.name.size());
        for (const ClothRange& cloth : topology.cloths) {
            names += cloth.name + std::string(longest - cloth.name.size(), '\0');
            put(vertices, std::int32_t{cloth.first_vertex});
            put(corners, std::int32_t{cloth.first_triangle});
        }
        put(vertices, std::int32_t{scene_->vertex_count()});
        put(corners, std::int32_t{scene_->triangle_count()});
        const auto cloths = static_cast<std::int64_t>(topology.cloths.size());
        array("times", "<f8", {count}, times);
        array("frames", "<i8", {count}, frames);
        array("frame_rate", "<f8", {}, rate);
        array("rest_positions", "<f8", {scene_->vertex_count(), 3}, rest);
        array("triangles", "<i4", {scene_->triangle_count(), 3}, triangles);
        array("uv", "<f8", {scene_->vertex_count(), 2}, uv);
        array("cloth_names", fmt::format("|S{}", longest), {cloths}, names);
        array("cloth_first_vertex", "<i4", {cloths + 1}, vertices);
        array("cloth_first_triangle", "<i4", {cloths + 1}, corners);
    }

    const ExportScene* scene_ = nullptr;
    fs::path path_;
    std::optional<GrowingFile> file_, velocities_;  // the second waits: a zip has one entry behind the other
    std::optional<Zip> zip_;
};

}  // namespace

std::unique_ptr<Exporter> npz_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<Npz>(file);
}

}  // namespace cloth::pipeline
