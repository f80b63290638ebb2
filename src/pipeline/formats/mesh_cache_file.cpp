#include "pipeline/formats/mesh_cache_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "pipeline/formats/assimp_animation.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/formats/npy.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

// ---------------------------------------------------------------- PC2 and MDD

/// Numbers of four bytes each, taken from the front.
class Words {
  public:
    Words(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}
    std::size_t left() const { return bytes_.size() / 4; }
    std::int32_t integer() { return std::bit_cast<std::int32_t>(take()); }
    float number() { return std::bit_cast<float>(take()); }

  private:
    std::uint32_t take() {
        std::uint32_t word = 0;
        std::memcpy(&word, bytes_.data(), 4);
        bytes_.remove_prefix(4);
        return big_endian_ ? word >> 24 | (word >> 8 & 0xff00u) | (word << 8 & 0xff0000u) | word << 24 : word;
    }
    std::string_view bytes_;
    bool big_endian_;
};

/// Samples of as many points.
void read_samples(Words& words, std::int32_t samples, std::int32_t points, const FilePlace& place,
                  MeshCache& cache) {
    if (samples < 1 || points < 1)
        place.fail(fmt::format("has {} frames of {} vertices; there must be at least one", samples, points));
    const double needed = 3.0 * samples * points;
    if (static_cast<double>(words.left()) < needed)
        place.fail(fmt::format("is cut short: {} frames of {} vertices have {:.0f} numbers, the file {}",
                               samples, points, needed, words.left()));
    for (std::int32_t f = 0; f < samples; ++f) {
        Points frame(points, 3);
        for (Eigen::Index i = 0; i < frame.size(); ++i) frame.data()[i] = words.number();
        cache.frames.push_back(std::move(frame));
    }
}

LoadedCache read_pc2(std::string_view bytes, const FilePlace& place) {
    constexpr std::string_view magic("POINTCACHE2\0", 12);
    if (!bytes.starts_with(magic) || bytes.size() < 32) place.fail("is no PC2: it does not begin as one");
    Words words(bytes.substr(magic.size()), false);
    words.integer();  // version
    const std::int32_t points = words.integer();
    words.number();  // first frame: the scene says when it stands
    const double frames_between = words.number();
    const std::int32_t samples = words.integer();
    if (!(frames_between > 0.0 && frames_between < 1e6))
        place.fail(fmt::format("has a sample every {:g} frames; must be above 0", frames_between));
    LoadedCache loaded;
    read_samples(words, samples, points, place, loaded.cache);
    if (frames_between != 1.0)
        loaded.notes.push_back(
            fmt::format("has a sample every {:g} frames; cache_rate counts the samples", frames_between));
    return loaded;
}

LoadedCache read_mdd(std::string_view bytes, const FilePlace& place) {
    Words words(bytes, true);
    if (words.left() < 2) place.fail("is no MDD: it is too short for one");
    const std::int32_t samples = words.integer(), points = words.integer();
    if (samples < 1 || words.left() < static_cast<std::size_t>(samples))
        place.fail(fmt::format("is no MDD, or cut short: it tells of {} frames", samples));
    LoadedCache loaded;
    for (std::int32_t f = 0; f < samples; ++f) loaded.cache.times.push_back(words.number());
    read_samples(words, samples, points, place, loaded.cache);
    return loaded;
}

// ---------------------------------------------------------------- a sequence of meshes

/// walk_0001.obj: "walk_", 1, four digits.
struct Numbered {
    std::string stem;
    std::int64_t number = 0;
    std::size_t digits = 0;
};

/// No digits: the name has none, or more than a number has.
Numbered numbered(const fs::path& path) {
    const std::string stem = path.stem().string();
    std::size_t first = stem.size();
    while (first > 0 && stem[first - 1] >= '0' && stem[first - 1] <= '9') --first;
    if (stem.size() - first > 18 || first == stem.size()) return {stem};
    return {stem.substr(0, first), std::stoll(stem.substr(first)), stem.size() - first};
}

/// The least number of a file of the sequence that is greater than `number`; -1: none.
std::int64_t next_there(const fs::path& path, const Numbered& first, std::int64_t number) {
    std::int64_t next = -1;
    std::error_code problem;
    for (const auto& entry : fs::directory_iterator(path.parent_path(), problem)) {
        if (entry.path().extension() != path.extension()) continue;
        const Numbered other = numbered(entry.path());
        if (other.digits < first.digits || other.stem != first.stem || other.number <= number) continue;
        if (next < 0 || other.number < next) next = other.number;
    }
    return next;
}

LoadedCache read_sequence(const fs::path& path) {
    const FilePlace place{path};
    const Numbered first = numbered(path);
    if (first.digits == 0)
        place.fail("is a single mesh; a sequence begins with a file that has a number, as walk_0001.obj");
    LoadedCache loaded;
    LoadedMesh mesh = read_mesh(path);
    loaded.notes = std::move(mesh.notes);
    loaded.cache.triangles = std::move(mesh.mesh.triangles);
    loaded.cache.frames.push_back(std::move(mesh.mesh.positions));
    for (std::int64_t number = first.number + 1;; ++number) {
        const fs::path next =
            path.parent_path() /
            (first.stem + fmt::format("{:0{}d}", number, first.digits) + path.extension().string());
        std::error_code problem;
        if (!fs::exists(next, problem)) {
            if (const std::int64_t later = next_there(path, first, number); later > 0)
                place.fail(fmt::format("the sequence has a gap: {} is missing, and it goes on at {}",
                                       next.filename().string(), later));
            return loaded;
        }
        loaded.cache.frames.push_back(read_points(next).mesh.positions);
    }
}

// ---------------------------------------------------------------- NumPy

MeshCache read_npz(const fs::path& path) {
    const FilePlace place{path};
    const NpzReader file(path);
    const auto called = [&](const char* name, const char* other) {
        return file.has(name) ? name : file.has(other) ? other : nullptr;
    };
    const char* const vertices = called("vertices", "positions");
    if (vertices == nullptr) place.fail("has no array vertices of the shape (frames, n, 3)");
    const auto words = [](const std::vector<std::int64_t>& shape) {
        return fmt::format("({})", fmt::join(shape, ", "));
    };
    MeshCache cache;
    const NumberArray positions = file.read(vertices);
    if (positions.shape.size() != 3 || positions.shape[2] != 3 || positions.numbers.empty())
        place.fail(fmt::format("its array {} has the shape {}; must be (frames, n, 3)", vertices,
                               words(positions.shape)));
    const std::int64_t frames = positions.shape[0], n = positions.shape[1];
    for (std::int64_t f = 0; f < frames; ++f)
        cache.frames.emplace_back(Eigen::Map<const Points>(positions.numbers.data() + 3 * n * f, n, 3));
    if (const char* const faces = called("faces", "triangles")) {
        const NumberArray corners = file.read(faces);
        if (corners.shape.size() != 2 || corners.shape[1] != 3)
            place.fail(
                fmt::format("its array {} has the shape {}; must be (m, 3)", faces, words(corners.shape)));
        cache.triangles.resize(corners.shape[0], 3);
        for (std::size_t i = 0; i < corners.numbers.size(); ++i) {
            const double corner = corners.numbers[i];
            if (!(corner >= 0.0 && corner < static_cast<double>(n) && corner == std::floor(corner)))
                place.fail(fmt::format("face {} (counted from 0) has the corner {:g}; there are {} vertices",
                                       i / 3, corner, n));
            cache.triangles.data()[i] = static_cast<int>(corner);
        }
    }
    if (file.has("times")) {
        cache.times = file.read("times").numbers;
        if (std::cmp_not_equal(cache.times.size(), frames))
            place.fail(fmt::format("has {} times for {} frames", cache.times.size(), frames));
    } else if (const char* const rate = called("fps", "frame_rate")) {
        const NumberArray per_second = file.read(rate);
        if (per_second.numbers.size() != 1 || !(per_second.numbers[0] > 0.0))
            place.fail(fmt::format("its {} must be one number above 0", rate));
        for (std::int64_t f = 0; f < frames; ++f)
            cache.times.push_back(static_cast<double>(f) / per_second.numbers[0]);
    }
    return cache;
}

// ---------------------------------------------------------------- all of them

void check_cache(const MeshCache& cache, const FilePlace& place) {
    for (std::size_t f = 0; f < cache.frames.size(); ++f) {
        const Points& frame = cache.frames[f];
        if (frame.rows() != cache.frames[0].rows())
            place.fail(fmt::format("frame {} (counted from 0) has {} vertices, the first {}", f, frame.rows(),
                                   cache.frames[0].rows()));
        for (Eigen::Index v = 0; v < frame.rows(); ++v)
            if (!frame.row(v).allFinite())
                place.fail(fmt::format("vertex {} of frame {} (counted from 0) is not finite", v, f));
    }
    for (std::size_t f = 0; f < cache.times.size(); ++f)
        if (!std::isfinite(cache.times[f]) || (f > 0 && !(cache.times[f] > cache.times[f - 1])))
            place.fail(
                fmt::format("frame {} (counted from 0) is at {:g} s; times must rise", f, cache.times[f]));
}

}  // namespace

LoadedCache read_mesh_cache(const fs::path& path) {
    const FilePlace place{path};
    const std::string extension = extension_of(path);
    // Of what assimp reads, what is known to have animations.
    const std::set<std::string> animated{".glb", ".gltf", ".fbx", ".dae"};
    std::error_code problem;
    if (fs::is_directory(path, problem)) place.fail("is a folder, not a file");
    if (!fs::exists(path, problem)) place.fail("there is no such file");
    LoadedCache loaded;
    if (extension == ".pc2" || extension == ".mdd") {
        std::string bytes;
        try {
            bytes = read_file(path);
        } catch (const Error& e) {
            throw Error(ExitCode::invalid_scene, e.what());
        }
        loaded = extension == ".pc2" ? read_pc2(bytes, place) : read_mdd(bytes, place);
    } else if (extension == ".obj" || extension == ".ply") {
        loaded = read_sequence(path);
    } else if (extension == ".npz") {
        if (!fs::is_regular_file(path, problem)) place.fail("is no regular file");
        loaded.cache = read_npz(path);
    } else if (animated.contains(extension)) {
        loaded = import_animation(path, extension);
    } else {
        place.fail("\"" + extension +
                   "\" is no format of a mesh that bends; PC2, MDD, NPZ, glTF, FBX, Collada and "
                   "sequences of OBJ or PLY are");
    }
    check_cache(loaded.cache, place);
    return loaded;
}

void write_mesh_cache(const MeshCache& cache, const fs::path& path) {
    GrowingFile file(path);
    NpzWriter zip(file.part(), path);
    const auto frames = static_cast<std::int64_t>(cache.frames.size()), n = cache.frames[0].rows();
    zip.begin("vertices", "<f8", {frames, n, 3});
    for (const Points& frame : cache.frames) {
        std::string bytes;
        put_all<double>(bytes, frame);
        zip.write(bytes);
    }
    zip.end();
    if (cache.triangles.rows() > 0) {
        std::string bytes;
        put_all<std::int32_t>(bytes, cache.triangles);
        zip.array("faces", "<i4", {cache.triangles.rows(), 3}, bytes);
    }
    if (!cache.times.empty()) {
        std::string bytes;
        for (const double time : cache.times) put(bytes, time);
        zip.array("times", "<f8", {frames}, bytes);
    }
    zip.close();
    file.finish();
}

}  // namespace cloth::pipeline
