// The golden gates: they pass what is the same, and each of them can fail.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/golden/golden.h"
#include "pipeline/picture/frame_builder.h"
#include "render/raster/rasterizer.h"
#include "sim/simulation.h"
#include "support/assignment_settings.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A small sheet that falls on a sphere, over a floor that takes the shadow.
SceneFile small_scene() {
    SceneFile file;
    file.name = "small";
    file.scene.name = "small";
    file.scene.simulation = testing::assignment_settings();
    file.scene.simulation.time_step = 1.0 / 300;
    ClothDesc cloth;
    cloth.grid.resolution = {12, 12};
    cloth.fabric = {};
    cloth.transform.rotate = Vec3(-90, 0, 0);
    cloth.transform.translate = Vec3(0, 0.3, 0);
    file.scene.cloths.push_back(cloth);
    ColliderDesc sphere;
    sphere.contact_offset = 0.01;
    file.scene.colliders.push_back(sphere);
    file.cloth_looks.resize(1);
    file.cloth_looks[0].material.front = {0.7f, 0.2f, 0.15f};
    file.collider_looks.resize(1);
    file.ground = render::Ground{-0.6f, {0.5f, 0.5f, 0.5f}};
    file.view.eye = {0.4f, 1.0f, 2.6f};
    file.expect.frames = {0, 6};
    return file;
}

State state_at(const SceneFile& file, int frame) {
    Simulation simulation(file.scene, 1);
    for (int i = 0; i < frame; ++i) simulation.advance_frame();
    State state = simulation.state();
    state.frame = frame;
    return state;
}

/// As on another machine: the goldens come from a build and a renderer of other names.
void rename_origin(const fs::path& golden) {
    std::string facts = slurp(golden / "golden.json");
    for (const char* key : {"\"build\": \"", "\"renderer\": \""}) {
        const std::size_t at = facts.find(key);
        REQUIRE(at != std::string::npos);
        facts.insert(at + std::string(key).size(), "another ");
    }
    spit(golden / "golden.json", facts);
}

/// Not a matcher: it would print the whole page, pictures and all.
bool page_has(const fs::path& page, const std::string& part) {
    return slurp(page).find(part) != std::string::npos;
}

render::Image noisy(render::Image image, int stride, int step) {
    for (std::size_t i = 0; i < image.rgba.size(); i += 4 * static_cast<std::size_t>(stride))
        image.rgba[i] =
            static_cast<std::uint8_t>(image.rgba[i] > 128 ? image.rgba[i] - step : image.rgba[i] + step);
    return image;
}

render::Image drawing(const SceneFile& file, const State& state) {
    static render::Rasterizer rasterizer(1);
    const Model model = build_model(file.scene);
    FrameBuilder builder(file, model);
    render::View view = file.view;
    view.width = golden_width;
    view.height = golden_height;
    return rasterizer.draw(builder.build(state), view);
}

}  // namespace

TEST_CASE("the state gate passes less than its tolerance and fails a vertex moved by just that", "[golden]") {
    State golden;
    golden.positions = VecX::LinSpaced(30, -3.0, 5.0);
    golden.velocities = VecX::Zero(30);
    const StateGate gate{false, 1e-6};
    CHECK(judge_state(golden, golden, gate).passed);
    for (int i = 0; i < 30; ++i)
        for (const double sign : {1.0, -1.0}) {
            State moved = golden;
            moved.positions[i] += sign * 1e-6;
            const StateVerdict verdict = judge_state(golden, moved, gate);
            CHECK_FALSE(verdict.passed);
            CHECK(verdict.worst_vertex == i / 3);
            CHECK_THAT(verdict.reason, Contains("vertex " + std::to_string(i / 3) + " is off by 1e-06 m"));
            moved.positions[i] = golden.positions[i] + sign * 0.9e-6;
            CHECK(judge_state(golden, moved, gate).passed);
        }
}

TEST_CASE("the exact state gate fails on one bit of a position or a velocity", "[golden]") {
    State golden;
    golden.positions = VecX::LinSpaced(30, -3.0, 5.0);
    golden.velocities = VecX::LinSpaced(30, 1.0, 2.0);
    const StateGate gate{true, 1e-6};
    CHECK(judge_state(golden, golden, gate).passed);
    State moved = golden;
    moved.positions[4] = std::nextafter(moved.positions[4], 10.0);
    CHECK_THAT(judge_state(golden, moved, gate).reason, Contains("vertex 1") && Contains("every bit"));
    moved = golden;
    moved.velocities[4] = std::nextafter(moved.velocities[4], 10.0);
    CHECK_THAT(judge_state(golden, moved, gate).reason, Contains("velocities differ"));
}

TEST_CASE("a state that is no number, or of another size, never passes", "[golden]") {
    State golden;
    golden.positions = golden.velocities = VecX::Zero(9);
    State lost = golden;
    lost.positions[3] = std::numeric_limits<double>::quiet_NaN();
    const StateVerdict verdict = judge_state(golden, lost, {false, 1e-6});
    CHECK_FALSE(verdict.passed);
    CHECK(verdict.worst_vertex == 1);
    State other;
    other.positions = other.velocities = VecX::Zero(12);
    CHECK_THAT(judge_state(golden, other, {false, 1e-6}).reason, Contains("4 vertices instead of 3"));
}

TEST_CASE("the picture gate passes noise of processors and fails what an eye would see", "[golden]") {
    const SceneFile file = small_scene();
    const State state = state_at(file, 6);
    const render::Image golden = drawing(file, state);
    CHECK(judge_image(golden, golden, true).passed);

    SECTION("noise: one step in some pixels") {
        // 230 of 921600 pixels off by 1 is what processors without AVX2 were seen to do.
        CHECK(judge_image(golden, noisy(golden, 1000, 1), false).passed);
        CHECK_FALSE(judge_image(golden, noisy(golden, 1000, 1), true).passed);
    }
    SECTION("many small differences: told by the share over 2") {
        CHECK_THAT(judge_image(golden, noisy(golden, 1000, 4), false).reason,
                   Contains("off by more than 2;"));
    }
    SECTION("a few great differences: told by the share over 32") {
        CHECK_THAT(judge_image(golden, noisy(golden, 5000, 40), false).reason,
                   Contains("off by more than 32;"));
    }
    SECTION("all pixels off by 2: told by the PSNR") {
        CHECK_THAT(judge_image(golden, noisy(golden, 1, 2), false).reason, Contains("PSNR"));
    }
    SECTION("another size") {
        render::Image small = golden;
        small.height -= 1;
        small.rgba.resize(small.rgba.size() - 4 * static_cast<std::size_t>(small.width));
        CHECK_THAT(judge_image(golden, small, false).reason, Contains("480x269 pixels instead of 480x270"));
    }
    SECTION("the shadow turned off") {
        SceneFile dark = file;
        dark.view.light.shadow = false;
        CHECK_FALSE(judge_image(golden, drawing(dark, state), false).passed);
    }
    SECTION("the frame before") {
        CHECK_FALSE(judge_image(golden, drawing(file, state_at(file, 5)), false).passed);
    }
    SECTION("a fold moved by a millimetre") {
        State moved = state;
        for (int i = 0; i < 12; ++i) moved.positions[3 * i + 1] += 1e-3;
        CHECK_FALSE(judge_image(golden, drawing(file, moved), false).passed);
    }
}

TEST_CASE("blessed goldens agree with the run that follows", "[golden]") {
    const TemporaryFolder folder;
    const SceneFile file = small_scene();
    const fs::path golden = folder / "golden/small";
    const GoldenResult first = bless_golden(file, golden, folder / "out", 1);
    CHECK(first.rows.empty());  // nothing stood there
    const GoldenResult result = compare_golden(file, golden, folder / "out", 2);
    CHECK(result.passed);
    REQUIRE(result.rows.size() == 2);
    CHECK(result.rows[1].frame == 6);
    CHECK(result.rows[1].state.largest_distance == 0);
    CHECK(result.rows[1].image.difference.largest == 0);
    CHECK(result.golden_build == build_fingerprint());
    for (const char* part : {"small: golden frames agree", "render_cloth bless small",
                             "\"before\":\"data:image/png;base64,iVBORw0KGgo"})
        CHECK(page_has(result.report, part));
    CHECK_FALSE(page_has(result.report, "difference\":"));
    // Also as goldens from elsewhere.
    rename_origin(golden);
    const GoldenResult elsewhere = compare_golden(file, golden, folder / "out", 1);
    CHECK(elsewhere.passed);
    CHECK_THAT(golden_table(elsewhere), Contains("another build") && Contains("another renderer"));
}

TEST_CASE("each golden gate fails when it should, for goldens of this build and from elsewhere", "[golden]") {
    const TemporaryFolder folder;
    const SceneFile file = small_scene();
    const fs::path golden = folder / "golden/small";
    bless_golden(file, golden, folder / "out", 1);
    const bool foreign = GENERATE(false, true);
    if (foreign) rename_origin(golden);
    const fs::path state_path = golden / "state_000006.bin", image_path = golden / "frame_000006.png";

    SECTION("one vertex moved by 1e-6 m") {
        State state = read_state(state_path);
        state.positions[3 * 77 + 1] += 1e-6;
        write_state(state, state_path);
        const GoldenResult result = compare_golden(file, golden, folder / "out", 1);
        CHECK_FALSE(result.passed);
        CHECK_FALSE(result.rows[1].state.passed);
        CHECK(result.rows[1].state.worst_vertex == 77);
        CHECK(result.rows[0].state.passed);
        CHECK_THAT(golden_table(result), Contains("frame 6, state: vertex 77") && Contains("small: differs"));
        for (const char* part : {"State: vertex 77", "\"moved\":\"data:", "\"moved_difference\":\"data:"})
            CHECK(page_has(result.report, part));
        CHECK_FALSE(page_has(result.report, "\"after\":"));
    }
    SECTION("a shadow turned off: the state agrees, the picture does not") {
        SceneFile dark = file;
        dark.view.light.shadow = false;
        const GoldenResult result = compare_golden(dark, golden, folder / "out", 1);
        CHECK_FALSE(result.passed);
        CHECK(result.rows[1].state.passed);
        CHECK_FALSE(result.rows[1].image.passed);
        CHECK(page_has(result.report, "small: golden frames differ"));
        for (const char* part : {"worst by", "\"after\":\"data:", "\"difference\":\"data:"})
            CHECK(page_has(result.report, part));
        CHECK_FALSE(page_has(result.report, "\"moved\":"));
    }
    SECTION("a frame shifted by one") {
        const State before = state_at(file, 5);
        write_state(before, state_path);
        render::write_png(drawing(file, before), image_path);
        const GoldenResult result = compare_golden(file, golden, folder / "out", 1);
        CHECK_FALSE(result.rows[1].state.passed);
        // The picture is drawn from the golden state: the renderer is not to blame.
        CHECK(result.rows[1].image.passed);
    }
    SECTION("a picture of the frame before") {
        render::write_png(drawing(file, state_at(file, 5)), image_path);
        const GoldenResult result = compare_golden(file, golden, folder / "out", 1);
        CHECK(result.rows[1].state.passed);
        CHECK_FALSE(result.rows[1].image.passed);
    }
    SECTION("another resolution") {
        SceneFile finer = file;
        finer.scene.cloths[0].grid.resolution = {13, 13};
        const GoldenResult result = compare_golden(finer, golden, folder / "out", 1);
        CHECK_THAT(result.rows[0].state.reason, Contains("169 vertices instead of 144"));
        CHECK_THAT(result.rows[0].image.reason, Contains("not drawn"));
    }
}

TEST_CASE("a missing golden fails and names the command that makes it", "[golden]") {
    const TemporaryFolder folder;
    SceneFile file = small_scene();
    const fs::path golden = folder / "golden/small";
    const auto message = [&] {
        try {
            compare_golden(file, golden, folder / "out", 1);
        } catch (const Error& e) {
            CHECK(e.code == ExitCode::golden_mismatch);
            return std::string(e.what());
        }
        return std::string("no Error");
    };
    CHECK_THAT(message(), Contains("is missing") && Contains("render_cloth bless small"));
    bless_golden(file, golden, folder / "out", 1);
    fs::remove(golden / "frame_000006.png");
    CHECK_THAT(message(), Contains("frame_000006.png is missing") && Contains("render_cloth bless small"));
    file.expect.frames.clear();
    CHECK_THAT(message(), Contains("has no golden frames") && Contains("[expect] frames"));
}

TEST_CASE("blessing compares old with new and drops goldens of frames that are no longer asked for",
          "[golden]") {
    const TemporaryFolder folder;
    SceneFile file = small_scene();
    const fs::path golden = folder / "golden/small";
    bless_golden(file, golden, folder / "out", 1);
    file.expect.frames = {0, 4};
    file.scene.simulation.gravity *= 1.01;
    const GoldenResult result = bless_golden(file, golden, folder / "out", 1);
    REQUIRE(result.rows.size() == 1);  // frame 4 had no golden
    CHECK(result.rows[0].frame == 0);
    CHECK_FALSE(fs::exists(golden / "state_000006.bin"));
    CHECK_FALSE(fs::exists(golden / "frame_000006.png"));
    CHECK(fs::exists(golden / "state_000004.bin"));
    CHECK(compare_golden(file, golden, folder / "out", 1).passed);
    file.scene.simulation.gravity *= 1.01;
    const GoldenResult again = bless_golden(file, golden, folder / "out", 1);
    REQUIRE(again.rows.size() == 2);
    CHECK(again.rows[1].state.largest_distance > 0);
    CHECK_FALSE(again.passed);
}
