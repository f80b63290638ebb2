// Time and memory of pictures: drawing, PNG, and both overlapped with encoding. Not a test.
//
// Wall time is what a user waits for; where others use the cores, "cpu_ms" (processor time of the whole
// process, and of ffmpeg where it takes part, a frame) is the steadier figure: cpu_ms / 2 is what two idle
// cores would need at best.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "pipeline/formats/video.h"
#include "render/raster/rasterizer.h"

namespace {

using namespace cloth;
using namespace cloth::render;

/// A sheet of 2 n² triangles draped over a ball, in waves that move with time.
struct Drape {
    explicit Drape(int n) : n_(n) {
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const auto a = static_cast<std::uint32_t>(j * (n + 1) + i),
                           b = a + static_cast<std::uint32_t>(n) + 1;
                triangles.insert(triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
            }
        const int rings = 32;
        for (int j = 0; j <= rings; ++j)
            for (int i = 0; i <= 2 * rings; ++i) {
                const float polar = pi * static_cast<float>(j) / rings,
                            azimuth = pi * static_cast<float>(i) / rings;
                const Float3 normal{std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                    -std::sin(polar) * std::sin(azimuth)};
                for (const float x : normal) {
                    ball_normals.push_back(x);
                    ball_positions.push_back(0.25f * x);
                }
            }
        for (int j = 0; j < rings; ++j)
            for (int i = 0; i < 2 * rings; ++i) {
                const auto a = static_cast<std::uint32_t>(j * (2 * rings + 1) + i), b = a + 2 * rings + 1;
                ball_triangles.insert(ball_triangles.end(), {a, b, a + 1, b, b + 1, a + 1});
            }
    }

    Frame frame(float time) {
        positions.clear();
        normals.clear();
        const auto place = [&](float s, float t) {
            const float x = s - 0.5f, z = t - 0.5f, r = std::hypot(x, z), angle = std::atan2(z, x);
            const float fall = r < 0.2f ? 0 : (r - 0.2f) * (0.8f + 0.25f * std::sin(9 * angle + time));
            return Float3{x * (1 - 0.4f * r), 0.26f - r * r * 0.4f - fall, z * (1 - 0.4f * r)};
        };
        const float step = 1e-3f;
        for (int j = 0; j <= n_; ++j)
            for (int i = 0; i <= n_; ++i) {
                const float s = static_cast<float>(i) / static_cast<float>(n_),
                            t = 1 - static_cast<float>(j) / static_cast<float>(n_);
                const Float3 p = place(s, t), a = place(s + step, t), b = place(s, t + step);
                const Float3 u{a[0] - p[0], a[1] - p[1], a[2] - p[2]},
                    v{b[0] - p[0], b[1] - p[1], b[2] - p[2]};
                const Float3 m{v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2],
                               v[0] * u[1] - v[1] * u[0]};
                const float length = std::hypot(m[0], m[1], m[2]);
                for (int k = 0; k < 3; ++k) {
                    positions.push_back(p[k]);
                    normals.push_back(m[k] / length);
                }
            }
        const Material red{.front = {0.34f, 0.01f, 0.013f}, .back = {0.63f, 0.32f, 0.04f}, .sheen = 0.4f};
        Frame result;
        result.ground = Ground{-0.5f, {0.57f, 0.57f, 0.57f}};
        result.surfaces.push_back({positions, normals, triangles, red, true});
        result.surfaces.push_back({ball_positions, ball_normals, ball_triangles, {}});
        return result;
    }

    static View view(int width, int height) {
        View v;
        v.width = width;
        v.height = height;
        v.eye = {1.05f, 0.72f, 1.85f};
        v.target = {0.08f, -0.13f, 0};
        v.field_of_view = 29;
        return v;
    }

    static constexpr float pi = std::numbers::pi_v<float>;
    int n_;
    std::vector<float> positions, normals, ball_positions, ball_normals;
    std::vector<std::uint32_t> triangles, ball_triangles;
};

double cpu_seconds() {
    double sum = 0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage use{};
        getrusage(who, &use);
        sum += static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
               1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
    }
    return sum;
}

/// Of the whole process [MiB]: greatest so far, and now.
double resident(const char* key) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind(key, 0) == 0) return std::stod(line.substr(line.find(':') + 1)) / 1024;
    return 0;
}

Rasterizer& rasterizer() {
    static Rasterizer one(2);
    return one;
}

int squares(std::int64_t triangles) {
    return static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 2)));
}

void report(benchmark::State& state, double cpu_start) {
    const auto frames = static_cast<double>(state.iterations());
    state.counters["cpu_ms"] = 1e3 * (cpu_seconds() - cpu_start) / frames;
    state.counters["MiB"] = resident("VmRSS");
}

/// Drawing alone. Arguments: height of the picture (16:9), triangles.
void draw(benchmark::State& state) {
    const int height = static_cast<int>(state.range(0));
    Drape drape(squares(state.range(1)));
    const View view = Drape::view(height * 16 / 9, height);
    rasterizer().draw(drape.frame(0), view);
    float time = 0;
    const double cpu = cpu_seconds();
    for (auto _ : state) {
        state.PauseTiming();
        const Frame frame = drape.frame(time += 0.02f);
        state.ResumeTiming();
        benchmark::DoNotOptimize(rasterizer().draw(frame, view));
    }
    report(state, cpu);
}
BENCHMARK(draw)
    ->Args({720, 20'000})
    ->Args({1080, 20'000})
    ->Args({720, 500'000})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// A picture → PNG in memory. Argument: height.
void png(benchmark::State& state) {
    const int height = static_cast<int>(state.range(0));
    Drape drape(100);
    const Image image = rasterizer().draw(drape.frame(0), Drape::view(height * 16 / 9, height));
    std::size_t bytes = 0;
    for (auto _ : state) bytes = encode_png(image).size();
    state.counters["KB"] = static_cast<double>(bytes) / 1000;
}
BENCHMARK(png)->Arg(720)->Arg(1080)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Draw, write PNGs and encode, each on a thread of its own, as a run does: time of a frame. Arguments:
/// height, triangles.
void draw_write_encode(benchmark::State& state) {
    const int height = static_cast<int>(state.range(0)), frames = 300;
    Drape drape(squares(state.range(1)));
    const View view = Drape::view(height * 16 / 9, height);
    const auto folder = std::filesystem::temp_directory_path() / ("bench_render." + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    rasterizer().draw(drape.frame(0), view);
    const double cpu = cpu_seconds();
    for (auto _ : state) {
        pipeline::VideoWriter movie(folder / "movie.mp4", view.width, view.height, {60, 18, 2});
        std::jthread png_writer, encoder;
        for (int i = 0; i < frames; ++i) {
            const Frame frame = drape.frame(0.02f * static_cast<float>(i));
            const auto image = std::make_shared<const Image>(rasterizer().draw(frame, view));
            png_writer = std::jthread([=] { write_png(*image, folder / (std::to_string(i) + ".png")); });
            if (encoder.joinable()) encoder.join();
            encoder = std::jthread([image, &movie] { movie.add(*image); });
        }
        encoder.join();
        movie.finish();
    }
    report(state, cpu);
    state.counters["cpu_ms"] = 1e3 * (cpu_seconds() - cpu) / static_cast<double>(state.iterations()) / frames;
    state.counters["frame_ms"] =
        benchmark::Counter(static_cast<double>(state.iterations() * frames) / 1e3,
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    std::filesystem::remove_all(folder);
}
BENCHMARK(draw_write_encode)
    ->Args({720, 20'000})
    ->Args({1080, 20'000})
    ->Args({720, 500'000})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
