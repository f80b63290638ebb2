// What scene files fill.

#include <catch2/catch.hpp>
#include <string>

#include "pipeline/scene_file/field.h"
#include "pipeline/scene_file/scene_text.h"
#include "render/image/image.h"
#include "sim/model.h"
#include "sim/scene/fabrics.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;

namespace {

/// All that files say of a fabric, to the bit.
std::string text_of(Fabric fabric) {
    std::string text;
    for (const Field& f : fields_of(fabric)) text += f.key + " = " + f.write() + "\n";
    return text;
}

}  // namespace

TEST_CASE("hem and contact's lengths follow a cloth's size, and the kept scene has them as numbers",
          "[scene_file]") {
    const SceneFile usual = parse(sheet());
    CHECK(usual.cloth_looks[0].hem == 2e-3);
    CHECK_THAT(usual.resolved(), Contains("contact_activation = 0.001\n") &&
                                     Contains("contact_thickness = 0.001\n") && Contains("hem = 0.002\n"));
    const SceneFile tiny = parse(sheet("size = [0.006, 0.008]\n"));  // a diagonal of 10 mm
    CHECK(tiny.cloth_looks[0].hem == Approx(1e-4));
    CHECK(*tiny.scene.cloths[0].contact_thickness == Approx(1e-4));
    CHECK(*tiny.scene.simulation.contact_activation == Approx(1e-4));
    CHECK(parse(sheet("size = [600, 800]\n")).cloth_looks[0].hem == 0.1);  // the widest
    CHECK(parse(tiny.resolved()).resolved() == tiny.resolved());
    CHECK(parse(sheet("size = [0.006, 0.008]\nhem = 0\n")).cloth_looks[0].hem == 0.0);
}

TEST_CASE("a cloth's pattern, threads, hem and the light's size reach the renderer", "[scene_file]") {
    const SceneFile f = parse(sheet(R"(color = "#ffffff"
pattern = "tartan"
pattern_scale = 0.3
pattern_colors = ["#ff0000", [0.0, 1.0, 0.0]]
weave = 0.002
weave_depth = 0.25
hem = 0.004
[[light]]
angle = 7.5
)"));
    const render::Material& m = f.cloth_looks[0].material;
    CHECK(m.pattern == render::Pattern::tartan);
    CHECK(m.pattern_scale == 0.3f);
    CHECK(m.pattern_colors[0] == render::Float3{1, 0, 0});
    CHECK(m.pattern_colors[1] == render::Float3{0, 1, 0});
    CHECK(m.pattern_colors[2] == render::Float3{0, 1, 0});  // the last one is repeated
    CHECK(m.pattern_on_back);
    CHECK(m.weave == 0.002f);
    CHECK(m.weave_depth == 0.25f);
    CHECK(f.cloth_looks[0].hem == 0.004);
    CHECK(f.view.light.angle == 7.5f);
    CHECK(difference(parse(f.resolved()), f) == "");
    CHECK_FALSE(parse(sheet("pattern = \"dots\"\nback_color = \"#000000\"\n"))
                    .cloth_looks[0]
                    .material.pattern_on_back);

    const TemporaryFolder folder;
    render::write_png({2, 1, {255, 0, 0, 255, 0, 255, 0, 255}}, folder / "print.png");
    const SceneFile printed = parse_scene(sheet("texture = \"print.png\"\n"), "s.toml", folder.path(), {});
    CHECK(printed.cloth_looks[0].material.pattern == render::Pattern::image);
    CHECK(printed.cloth_looks[0].material.image->width == 2);
}

TEST_CASE("the assignment's scenes hold the assignment's numbers", "[scene_file]") {
    for (const std::string name : {"seed_sheet", "seed_kick", "seed_drag"}) {
        INFO(name);
        const SceneFile f = load_scene(name);
        const Scene& s = f.scene;
        CHECK(s.simulation.gravity == Vec3(0, -1800.8, 0));
        CHECK(s.simulation.steps_per_frame() == 1);
        CHECK(s.simulation.step_size() == 0.001);
        CHECK(s.simulation.integrator == IntegratorKind::linearly_implicit_euler);
        CHECK(s.simulation.hessian == LinearHessian::assignment);
        CHECK(s.simulation.contact == ContactKind::velocity_filter);
        REQUIRE(s.cloths.size() == 1);
        CHECK(s.cloths[0].grid.size == Vec2(1, 1));
        CHECK(s.cloths[0].grid.resolution == std::array<int, 2>{20, 20});
        CHECK(s.cloths[0].grid.diagonals == Diagonals::uniform);
        CHECK(s.cloths[0].velocity == Vec3(0, 0, name == "seed_kick" ? 30 : 0));
        CHECK(s.cloths[0].fabric.density == 1.0);
        CHECK(s.cloths[0].fabric.thickness == 1.0);
        // E/((1+ν)(1-2ν)) ν and E/(2(1+ν)) for E = 1e5, ν = 0.4
        CHECK(*s.cloths[0].fabric.mu == Approx(1e5 * 0.4 / (1.4 * 0.2)).epsilon(1e-15));
        CHECK(*s.cloths[0].fabric.lambda == Approx(1e5 / 2.8).epsilon(1e-15));
        REQUIRE(s.colliders.size() == 1);
        CHECK(s.colliders[0].center == Vec3(0, 0, 0.4));
        CHECK(s.colliders[0].radius == 0.2);
        CHECK(*s.colliders[0].contact_radius == 0.22);
        CHECK(s.colliders[0].enabled == (name == "seed_kick"));
        CHECK(s.colliders[0].friction == 0.0);
        CHECK(f.output.playback_rate == 50.0);
        const Model model = build_model(s);
        CHECK(model.triangle_count() == 722);
        CHECK(model.pinned.size() == 20);
    }
}

TEST_CASE("a drag sees through the scene's camera as OpenGL does", "[scene_file]") {
    const SceneFile f =
        parse(sheet("[camera]\nposition = [1, 2, 3]\ntarget = [0, 0.5, -1]\nfield_of_view = 90\n"
                    "[[drag]]\nviewport = [200, 100]\npath = [[0, 1, 1], [1, 2, 2]]\n"));
    const DragDesc& d = f.scene.drags[0];
    const auto project = [&](const Vec3& p) -> Vec3 {
        return (d.projection * d.view * p.homogeneous()).hnormalized();
    };
    // The target stands in the middle of the picture.
    CHECK(project(Vec3(0, 0.5, -1)).head<2>().norm() == Approx(0.0).margin(1e-14));
    // 90 degrees from lower to upper edge: what is as far up as ahead lies on the upper edge (y = 1).
    const Vec3 ahead = (Vec3(0, 0.5, -1) - Vec3(1, 2, 3)).normalized();
    const Vec3 right = ahead.cross(Vec3::UnitY()).normalized(), up = right.cross(ahead);
    const Vec3 upper = project(Vec3(1, 2, 3) + 2 * ahead + 2 * up);
    CHECK(upper.x() == Approx(0.0).margin(1e-14));
    CHECK(upper.y() == Approx(1.0));
    // Twice as wide as high, so the right edge (x = 1) is twice as far aside.
    CHECK(project(Vec3(1, 2, 3) + 2 * ahead + 4 * right).x() == Approx(1.0));
    // Between the clip planes depth grows with distance.
    const double near = project(Vec3(1, 2, 3) + 0.5 * ahead).z(),
                 far = project(Vec3(1, 2, 3) + 5 * ahead).z();
    CHECK(-1.0 < near);
    CHECK(near < far);
    CHECK(far < 1.0);
}

TEST_CASE("a fabric is given by name, or by a name and what differs", "[scene_file]") {
    const auto fabric = [&](const std::string& value, const Overrides& overrides = {}) {
        const SceneFile file = parse(sheet("fabric = " + value + "\n"), overrides);
        INFO(file.resolved());
        // The resolved scene holds the numbers, whatever becomes of the table.
        CHECK_THAT(file.resolved(), !Contains("base"));
        CHECK(text_of(parse(file.resolved()).scene.cloths[0].fabric) == text_of(file.scene.cloths[0].fabric));
        return file.scene.cloths[0].fabric;
    };
    for (const NamedFabric& named : named_fabrics()) {
        INFO(named.fabric.name);
        CHECK(text_of(fabric("\"" + named.fabric.name + "\"")) == text_of(named.fabric));
    }
    const Fabric& cotton = find_fabric("cotton")->fabric;
    Fabric heavier = cotton;
    heavier.density = 0.2;
    CHECK(text_of(fabric("{ density = 0.2, base = \"cotton\" }")) == text_of(heavier));
    heavier.name = "canvas";
    CHECK(text_of(fabric("{ base = \"cotton\", density = 0.2, name = \"canvas\" }")) == text_of(heavier));
    // Of a table of numbers alone it is the numbers; of nothing, cotton.
    CHECK(text_of(fabric("{ density = 0.2 }")) == text_of({.density = 0.2}));
    CHECK(text_of(parse(sheet()).scene.cloths[0].fabric) == text_of(cotton));
    CHECK(text_of(parse(sheet(), {"cloth.fabric.density=0.2", "cloth.fabric.name=canvas"})
                      .scene.cloths[0]
                      .fabric) == text_of(heavier));
    // Overrides know both ways of writing.
    CHECK(fabric("\"cotton\"", {"cloth.fabric.density=0.3"}).density == 0.3);
    CHECK(fabric("\"cotton\"", {"cloth.fabric.density=0.3"}).bending == cotton.bending);
    CHECK(fabric("{ density = 0.2 }", {"cloth.fabric=silk"}).name == "silk");
    CHECK(fabric("{ base = \"cotton\", density = 0.2 }", {"cloth.fabric.base=silk"}).name == "silk");
    CHECK(fabric("{ base = \"cotton\", density = 0.2 }", {"cloth.fabric.base=silk"}).density == 0.2);
    CHECK_THAT(refusal(sheet("fabric = \"cotton\"\n"), {"cloth.fabric=silc"}),
               Catch::StartsWith("--set cloth.fabric=silc: cloth[0].fabric: there is no fabric"));
}

TEST_CASE("what changes a base leaves none of its values without a meaning", "[scene_file]") {
    const auto fabric = [](const std::string& keys) {
        return parse(sheet("fabric = { strain_limit = 0, " + keys + " }\n")).scene.cloths[0].fabric;
    };
    const Fabric plain = fabric("base = \"cotton\", membrane = \"neo_hookean\"");
    CHECK(!plain.young_weft);
    CHECK(!plain.shear_modulus);
    CHECK(plain.young_modulus == find_fabric("cotton")->fabric.young_modulus);
    CHECK(!fabric("base = \"cotton\", mu = 1, lambda = 1").young_weft);
    CHECK(!fabric("base = \"cotton\", bending = 1e-3").bending_bias);
    CHECK(fabric("base = \"cotton\", bending = 1e-3, bending_bias = 5e-4").bending_bias == 5e-4);
    CHECK(fabric("base = \"cotton\", friction = 0.1").bending_bias);
    CHECK(!fabric("base = \"paper\", bending_model = \"quadratic\"").yield_curvature);
    CHECK(fabric("base = \"paper\"").yield_curvature);
}

TEST_CASE("zero leaves out a strain limit or a yield", "[scene_file]") {
    const std::string text = sheet(
        "fabric = { strain_limit = 1.05, bending_model = \"hinges\", yield_curvature = 90 }\n"
        "[simulation]\nintegrator = \"tr_bdf2\"\n");
    CHECK(parse(text).scene.cloths[0].fabric.strain_limit == 1.05);
    CHECK_THAT(parse(text).resolved(), Contains("strain_limit = 1.05"));
    const SceneFile f = parse(text, {"cloth.fabric.strain_limit=0", "cloth.fabric.yield_curvature=0"});
    CHECK(!f.scene.cloths[0].fabric.strain_limit);
    CHECK(!f.scene.cloths[0].fabric.yield_curvature);
    CHECK_THAT(f.resolved(), Contains("strain_limit = 0.0"));
}
