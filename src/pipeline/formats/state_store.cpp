#include "pipeline/formats/state_store.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include <Eigen/Core>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view state_magic = "CLOTHST1";
constexpr std::string_view topology_magic = "CLOTHTP1";

// ---------------------------------------------------------------- bytes of a value

class ByteWriter {
  public:
    template <class T>
    void value(T v) {
        static_assert(std::is_arithmetic_v<T>);
        put(bytes, v);
    }
    void count(std::size_t n) { value(static_cast<std::uint64_t>(n)); }
    void text(const std::string& s) {
        count(s.size());
        bytes += s;
    }
    /// All first bytes, then all second bytes …: neighbours share sign, exponent and leading digits, so this
    /// compresses where plain doubles hardly do.
    void doubles(const double* data, std::size_t n) {
        count(n);
        const char* source = reinterpret_cast<const char*>(data);
        const std::size_t start = bytes.size();
        bytes.resize(start + 8 * n);
        for (std::size_t byte = 0; byte < 8; ++byte)
            for (std::size_t i = 0; i < n; ++i) bytes[start + byte * n + i] = source[8 * i + byte];
    }
    std::string bytes;
};

/// Throws std::length_error where the bytes end too early.
class ByteReader {
  public:
    explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
    template <class T>
    T value() {
        T v;
        std::memcpy(&v, take(sizeof v).data(), sizeof v);
        return v;
    }
    /// A number of entries of `size` bytes each that must still follow.
    std::size_t count(std::size_t size) {
        const auto n = value<std::uint64_t>();
        if (n > rest_.size() / size) throw std::length_error("too short");
        return static_cast<std::size_t>(n);
    }
    std::string text() {
        const std::size_t n = count(1);
        return std::string(take(n));
    }
    template <class Resize>
    void doubles(Resize resize) {
        const std::size_t n = count(8);
        const std::string_view source = take(8 * n);
        char* target = reinterpret_cast<char*>(resize(n));
        for (std::size_t byte = 0; byte < 8; ++byte)
            for (std::size_t i = 0; i < n; ++i) target[8 * i + byte] = source[byte * n + i];
    }
    bool at_end() const { return rest_.empty(); }

  private:
    std::string_view take(std::size_t n) {
        if (n > rest_.size()) throw std::length_error("too short");
        const std::string_view head = rest_.substr(0, n);
        rest_.remove_prefix(n);
        return head;
    }
    std::string_view rest_;
};

// ---------------------------------------------------------------- file: magic, xxHash of the rest, zstd
// frame

std::string pack(std::string_view magic, std::string_view payload, Compression compression) {
    std::string body(ZSTD_compressBound(payload.size()), '\0');
    const int level = compression == Compression::fast ? 1 : 19;
    const std::size_t size = ZSTD_compress(body.data(), body.size(), payload.data(), payload.size(), level);
    if (ZSTD_isError(size)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
    body.resize(size);
    ByteWriter file;
    file.bytes = magic;
    file.value(static_cast<std::uint64_t>(XXH3_64bits(body.data(), body.size())));
    file.bytes += body;
    return file.bytes;
}

std::string unpack(std::string_view magic, const fs::path& path) {
    const std::string file = read_file(path);
    const auto fail = [&](const std::string& what) -> void {
        throw Error(ExitCode::other, path.string() + ": " + what);
    };
    const std::size_t head = magic.size() + 8;
    if (file.size() < head) fail("cut short");
    if (std::string_view(file).substr(0, magic.size()) != magic)
        fail(fmt::format("not a file of kind {}", magic));
    std::uint64_t stored;
    std::memcpy(&stored, file.data() + magic.size(), sizeof stored);
    const std::string_view body = std::string_view(file).substr(head);
    if (stored != XXH3_64bits(body.data(), body.size())) fail("damaged or cut short (its checksum is wrong)");
    // The size that a frame claims is not believed before its bytes are there.
    const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                            &ZSTD_freeDStream);
    if (!stream) throw std::bad_alloc();
    ZSTD_inBuffer in{body.data(), body.size(), 0};
    std::string payload, chunk(ZSTD_DStreamOutSize(), '\0');
    std::size_t left = 1;
    while (left != 0) {
        ZSTD_outBuffer out{chunk.data(), chunk.size(), 0};
        left = ZSTD_decompressStream(stream.get(), &out, &in);
        if (ZSTD_isError(left)) fail("damaged");
        payload.append(chunk, 0, out.pos);
        if (left != 0 && in.pos == in.size && out.pos < out.size) fail("damaged");
    }
    if (in.pos != in.size) fail("damaged");
    return payload;
}

/// Runs `read` over the payload; what does not fit becomes an Error naming the file.
template <class Read>
void parse(const fs::path& path, std::string_view payload, Read read) {
    ByteReader reader(payload);
    try {
        read(reader);
    } catch (const std::length_error&) {
        throw Error(ExitCode::other, path.string() + ": damaged (shorter than it says)");
    }
    if (!reader.at_end()) throw Error(ExitCode::other, path.string() + ": damaged (longer than it says)");
}

}  // namespace

// ---------------------------------------------------------------- states

std::string state_bytes(const State& state) {
    ByteWriter out;
    out.value(static_cast<std::uint32_t>(state_format));
    out.value(state.step);
    out.value(state.frame);
    out.value(state.time);
    out.value(static_cast<std::uint8_t>(state.integrator));
    out.value(state.events_done);
    out.doubles(state.positions.data(), static_cast<std::size_t>(state.positions.size()));
    out.doubles(state.velocities.data(), static_cast<std::size_t>(state.velocities.size()));
    out.count(state.collider_on.size());
    for (const std::uint8_t on : state.collider_on) out.value(on);
    out.count(state.drags.size());
    for (const DragState& drag : state.drags) {
        out.value(static_cast<std::uint8_t>(drag.pressed));
        out.count(drag.vertices.size());
        for (const int vertex : drag.vertices) out.value(static_cast<std::int32_t>(vertex));
        out.count(drag.anchors.size());
        for (const Vec3& anchor : drag.anchors)
            for (int i = 0; i < 3; ++i) out.value(anchor[i]);
        for (int i = 0; i < 3; ++i) out.value(drag.grabbed[i]);
    }
    out.doubles(state.rest_folds.data(), static_cast<std::size_t>(state.rest_folds.size()));
    // Later than the rest of the format: most states do without.
    if (state.indefinite) out.value(std::uint8_t{1});
    return out.bytes;
}

std::string write_state(const State& state, const fs::path& path, Compression compression, Sync sync) {
    const std::string bytes = pack(state_magic, state_bytes(state), compression);
    write_file(path, bytes, sync);
    return fingerprint(bytes);
}

State read_state(const fs::path& path) {
    const std::string payload = unpack(state_magic, path);
    State state;
    parse(path, payload, [&](ByteReader& in) {
        if (const auto format = in.value<std::uint32_t>(); format != state_format)
            throw Error(ExitCode::other, fmt::format("{}: state format {}, this program reads {}",
                                                     path.string(), format, state_format));
        state.step = in.value<std::int64_t>();
        state.frame = in.value<std::int64_t>();
        state.time = in.value<double>();
        const auto integrator = in.value<std::uint8_t>();
        if (integrator > 3) throw Error(ExitCode::other, path.string() + ": damaged (unknown integrator)");
        state.integrator = static_cast<IntegratorKind>(integrator);
        state.events_done = in.value<std::uint32_t>();
        const auto sized = [](VecX& vector) {
            return [&vector](std::size_t n) {
                vector.resize(static_cast<Eigen::Index>(n));
                return vector.data();
            };
        };
        in.doubles(sized(state.positions));
        in.doubles(sized(state.velocities));
        state.collider_on.resize(in.count(1));
        for (std::uint8_t& on : state.collider_on) on = in.value<std::uint8_t>();
        state.drags.resize(in.count(1));
        for (DragState& drag : state.drags) {
            drag.pressed = in.value<std::uint8_t>() != 0;
            drag.vertices.resize(in.count(4));
            for (int& vertex : drag.vertices) vertex = in.value<std::int32_t>();
            drag.anchors.resize(in.count(24));
            for (Vec3& anchor : drag.anchors)
                for (int i = 0; i < 3; ++i) anchor[i] = in.value<double>();
            for (int i = 0; i < 3; ++i) drag.grabbed[i] = in.value<double>();
        }
        in.doubles(sized(state.rest_folds));
        if (!in.at_end()) state.indefinite = in.value<std::uint8_t>() != 0;
    });
    if (state.frame < 0 || state.positions.size() != state.velocities.size() ||
        state.positions.size() % 3 != 0)
        throw Error(ExitCode::other, path.string() + ": damaged (its numbers do not belong together)");
    return state;
}

std::string state_hash(const State& state) {
    XXH3_state_t* hash = XXH3_createState();
    XXH3_64bits_reset(hash);
    for (const VecX* vector : {&state.positions, &state.velocities})
        XXH3_64bits_update(hash, vector->data(), sizeof(double) * static_cast<std::size_t>(vector->size()));
    const auto digest = static_cast<std::uint64_t>(XXH3_64bits_digest(hash));
    XXH3_freeState(hash);
    return fmt::format("{:016x}", digest);
}

// ---------------------------------------------------------------- topology

void write_topology(const Model& model, const fs::path& path) {
    ByteWriter out;
    out.doubles(model.rest_positions.data(), static_cast<std::size_t>(model.rest_positions.size()));
    out.count(static_cast<std::size_t>(model.triangles.rows()));
    for (Eigen::Index t = 0; t < model.triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c) out.value(static_cast<std::int32_t>(model.triangles(t, c)));
    out.count(model.cloths.size());
    for (const ClothRange& cloth : model.cloths) {
        out.text(cloth.name);
        for (const int number :
             {cloth.first_vertex, cloth.vertex_count, cloth.first_triangle, cloth.triangle_count})
            out.value(static_cast<std::int32_t>(number));
    }
    write_if_changed(path, pack(topology_magic, out.bytes, Compression::fast));
}

Topology read_topology(const fs::path& path) {
    const std::string payload = unpack(topology_magic, path);
    Topology topology;
    parse(path, payload, [&](ByteReader& in) {
        in.doubles([&](std::size_t n) {
            topology.rest_positions.resize(static_cast<Eigen::Index>(n / 3), 3);
            if (n % 3 != 0) throw std::length_error("three coordinates a vertex");
            return topology.rest_positions.data();
        });
        topology.triangles.resize(static_cast<Eigen::Index>(in.count(12)), 3);
        for (Eigen::Index t = 0; t < topology.triangles.rows(); ++t)
            for (int c = 0; c < 3; ++c) topology.triangles(t, c) = in.value<std::int32_t>();
        topology.cloths.resize(in.count(24));
        for (ClothRange& cloth : topology.cloths) {
            cloth.name = in.text();
            for (int* number :
                 {&cloth.first_vertex, &cloth.vertex_count, &cloth.first_triangle, &cloth.triangle_count})
                *number = in.value<std::int32_t>();
        }
    });
    return topology;
}

bool same_topology(const Topology& topology, const Model& model) {
    return topology.rest_positions.rows() == model.rest_positions.rows() &&
           topology.triangles.rows() == model.triangles.rows() &&
           topology.rest_positions == model.rest_positions && topology.triangles == model.triangles;
}

}  // namespace cloth::pipeline
