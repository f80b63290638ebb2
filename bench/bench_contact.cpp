// Time of barrier contact and its split, and how far a run at one tolerance is from one at another. Not a
// test.
//
//   bench_contact --write reference.bin --tolerance 1e-6
//   bench_contact --compare reference.bin --tolerance 1e-2
//   bench_contact --compare reference.bin --newton-speed 0.1 --single
//
// --single starts every frame from the reference's last one: the error of a step, free of how folds that
// buckle one way or the other grow apart.
//
// A sheet of 1 m drapes over a sphere ("drape") or falls edge-on onto a floor ("pile"): E h = 500 N/m,
// D = 1e-5 N m, 0.15 kg/m², friction 0.3, implicit Euler, self-contact on. Any other scene is one of the
// program's, which keeps its own settings but for --vertices and --set:
//
//   bench_contact --scene drape_sphere --vertices 100 --frames 300 --set simulation.accuracy=draft

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_file.h"
#include "sim/simulation.h"

namespace {

using namespace cloth;

struct Options {
    std::string scene = "drape", write, compare;
    int vertices = 100, frames = 30, frame_rate = 60, substeps = 1, iterations = 100, threads = 0;
    double tolerance = 1e-6, newton_speed = 0.03, sliding_speed = 1e-3;
    std::vector<std::string> set;
    bool quiet = false, single = false;
};

Scene make_scene(const Options& o) {
    if (o.scene != "drape" && o.scene != "pile") {
        pipeline::Overrides set(o.set.begin(), o.set.end());
        set.push_back("cloth.resolution=" + std::to_string(o.vertices));
        return pipeline::load_scene(o.scene, set).scene;
    }
    Scene scene;
    scene.simulation.frame_rate = o.frame_rate;
    scene.simulation.substeps = o.substeps;
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.contact = ContactKind::barrier;
    scene.simulation.newton_tolerance = o.tolerance;
    scene.simulation.newton_speed = o.newton_speed;
    scene.simulation.newton_iterations = o.iterations;
    scene.simulation.sliding_speed = o.sliding_speed;
    ClothDesc cloth;
    cloth.grid.resolution = {o.vertices, o.vertices};
    cloth.grid.diagonals = Diagonals::alternating;
    cloth.fabric = {
        .density = 0.15, .thickness = 5e-4, .young_modulus = 1e6, .bending = 1e-5, .friction = 0.3};
    ColliderDesc collider;
    collider.friction = 0.3;
    if (o.scene == "drape") {
        cloth.transform = {1.0, {-90.0, 12.0, 0.0}, {0.0, 0.3, 0.0}};
        collider.shape = Shape::sphere;
        collider.radius = 0.25;
    } else {
        cloth.bump = 0.01;
        cloth.transform = {1.0, {4.0, 0.0, 0.0}, {0.0, 0.52, 0.0}};
        collider.shape = Shape::plane;
    }
    scene.cloths.push_back(cloth);
    scene.colliders.push_back(collider);
    return scene;
}

int fail(const std::string& message) {
    std::fprintf(stderr, "bench_contact: %s\n", message.c_str());
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (key == "--quiet") {
            o.quiet = true;
            continue;
        }
        if (key == "--single") {
            o.single = true;
            continue;
        }
        if (i + 1 == argc) return fail(key + " needs a value");
        const std::string value = argv[++i];
        if (key == "--scene")
            o.scene = value;
        else if (key == "--write")
            o.write = value;
        else if (key == "--compare")
            o.compare = value;
        else if (key == "--vertices")
            o.vertices = std::stoi(value);
        else if (key == "--frames")
            o.frames = std::stoi(value);
        else if (key == "--frame-rate")
            o.frame_rate = std::stoi(value);
        else if (key == "--substeps")
            o.substeps = std::stoi(value);
        else if (key == "--set")
            o.set.push_back(value);
        else if (key == "--threads")
            o.threads = std::stoi(value);
        else if (key == "--iterations")
            o.iterations = std::stoi(value);
        else if (key == "--tolerance")
            o.tolerance = std::stod(value);
        else if (key == "--newton-speed")
            o.newton_speed = std::stod(value);
        else if (key == "--sliding-speed")
            o.sliding_speed = std::stod(value);
        else
            return fail("unknown option " + key);
    }
    Simulation simulation(make_scene(o), o.threads);
    const auto size = static_cast<std::streamsize>(simulation.state().positions.size() * sizeof(double));
    std::ofstream out;
    std::ifstream in;
    if (!o.write.empty()) out.open(o.write, std::ios::binary);
    if (!o.compare.empty()) {
        in.open(o.compare, std::ios::binary);
        if (!in) return fail("cannot open " + o.compare);
    }
    FrameReport sum;
    const std::clock_t clock_start = std::clock();
    double seconds = 0.0, worst_low = 0.0, worst_mean = 0.0, worst_velocity = 0.0, sum_rms = 0.0,
           worst_vertex = 0.0;
    VecX reference(simulation.state().positions.size()), velocity(reference.size());
    std::printf(
        "frame  s      low[m]   mean[m]  Newton CG   factor retry contacts residual  gap[m]   stretch\n");
    for (int k = 1; k <= o.frames; ++k) {
        if (o.single && k > 1) {
            State state = simulation.state();
            state.positions = reference;
            state.velocities = velocity;
            simulation.restore(state);
        }
        const auto start = std::chrono::steady_clock::now();
        const FrameReport report = simulation.advance_frame();
        const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        seconds += took;
        merge(sum, report);
        const VecX& x = simulation.state().positions;
        const VecX& v = simulation.state().velocities;
        const auto heights = x.reshaped(3, x.size() / 3).row(1);
        if (!o.quiet) {
            std::printf("%5d %6.3f %8.4f %8.4f %5d %6d %5d %4d %7d  %8.1e %8.1e %7.4f", k, took,
                        heights.minCoeff(), heights.mean(), report.iterations, report.cg_iterations,
                        report.factorizations, report.retries, report.contacts, report.residual,
                        report.smallest_gap, report.largest_stretch);
        }
        if (out.is_open()) {
            out.write(reinterpret_cast<const char*>(x.data()), size);
            out.write(reinterpret_cast<const char*>(v.data()), size);
            out.flush();
        }
        if (in && in.read(reinterpret_cast<char*>(reference.data()), size) &&
            in.read(reinterpret_cast<char*>(velocity.data()), size)) {
            const auto other = reference.reshaped(3, reference.size() / 3).row(1);
            const double low = std::abs(heights.minCoeff() - other.minCoeff());
            const double mean = std::abs(heights.mean() - other.mean());
            const Vec3 mine = v.reshaped(3, v.size() / 3).rowwise().mean();
            const Vec3 its = velocity.reshaped(3, v.size() / 3).rowwise().mean();
            const double speed = (mine - its).norm() / its.norm();
            const auto differences = (v - velocity).reshaped(3, v.size() / 3).colwise().norm();
            const double rms = std::sqrt(differences.squaredNorm() / static_cast<double>(differences.size()));
            sum_rms += rms;
            worst_vertex = std::max(worst_vertex, differences.maxCoeff());
            worst_low = std::max(worst_low, low);
            worst_mean = std::max(worst_mean, mean);
            worst_velocity = std::max(worst_velocity, speed);
            if (!o.quiet) std::printf("  off: low %.2e mean %.2e m, velocity %.1e", low, mean, speed);
        }
        if (!o.quiet) std::printf("\n");
        std::fflush(stdout);
        if (!report.converged) return fail("did not converge at frame " + std::to_string(k));
    }
    // Where others use the cores, processor time is the steadier figure.
    const double busy = static_cast<double>(std::clock() - clock_start) / CLOCKS_PER_SEC;
    std::printf("%.3f s/frame (processor: %.3f), %d Newton, %d CG, %d factorizations, %d retries\n",
                seconds / o.frames, busy / o.frames, sum.iterations, sum.cg_iterations, sum.factorizations,
                sum.retries);
    const ContactTimes& t = sum.contact_times;
    const double named = t.detection + t.assembly + t.factorization + t.solution + t.evaluation;
    std::printf(
        "a frame: detection %.3f, assembly %.3f, factorization %.3f, conjugate gradients %.3f, values "
        "and gradients %.3f, other %.3f s\n",
        t.detection / o.frames, t.assembly / o.frames, t.factorization / o.frames, t.solution / o.frames,
        t.evaluation / o.frames, (seconds - named) / o.frames);
    if (!o.compare.empty()) {
        std::printf(
            "off the reference at most: lowest point %.2e m, mean height %.2e m, mean velocity %.1e, of a "
            "vertex %.2f m/s; "
            "rms over the vertices, mean over the frames: %.4f m/s\n",
            worst_low, worst_mean, worst_velocity, worst_vertex, sum_rms / o.frames);
    }
}
