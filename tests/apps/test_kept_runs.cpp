// What is made of a kept run, and the verbs beside runs: goldens and validation.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("pictures are drawn again from kept states, without the scene and mesh they came from", "[cli]") {
    const Workplace place;
    spit(place / "cloth é.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    REQUIRE(place.run(base + "--frames 4 --set 'cloth.mesh=\"cloth é.obj\"'").code == 0);
    const std::string picture = slurp(place / "o/frames/frame_000003.png");
    const std::string movie = slurp(place / "o/sheet.mp4");
    fs::remove(place / "cloth é.obj");
    fs::remove(place / "sheet.toml");
    fs::rename(place / "o", place / "moved");

    SECTION("all of them") {
        fs::remove_all(place / "moved/frames");
        fs::remove(place / "moved/sheet.mp4");
        const Outcome outcome = place.run("render --out moved --quiet");
        CHECK(outcome.code == 0);
        CHECK_THAT(outcome.out, Contains("sheet: 4 pictures of 64x48, a movie at 60 frames/s"));
        CHECK(slurp(place / "moved/frames/frame_000003.png") == picture);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("some of them; the movie follows once all are there") {
        fs::remove_all(place / "moved/frames");
        fs::remove(place / "moved/sheet.mp4");
        CHECK(place.run("render --out moved --quiet --frames 2:4").code == 0);
        CHECK(pipeline::RunFolder::open(place / "moved").kept_images() == std::vector<std::int64_t>{2, 3});
        CHECK_FALSE(fs::exists(place / "moved/sheet.mp4"));
        check_refusal(place.run("encode --out moved --quiet"), 1, {"pictures of 2 of its 4 frames"});
        CHECK(place.run("render --out moved --quiet --frames 0:2").code == 0);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("the movie alone") {
        fs::remove(place / "moved/sheet.mp4");
        CHECK(place.run("encode --out moved --quiet").code == 0);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("at another size") {
        CHECK(place.run("render --out moved --quiet --size 96x64").code == 0);
        CHECK(render::read_png(place / "moved/frames/frame_000000.png").width == 96);
        check_refusal(place.run("render --out moved --quiet --size 64x48 --frames 1:2"), 1,
                      {"frame_000001.png is 64x48, the pictures before it 96x64"});
    }
    SECTION("a flag's bad value is refused as at a run") {
        check_refusal(place.run("render --out moved --shade blue"), 2, {"--shade blue", "one of stretch, "});
        check_refusal(place.run("encode --out moved --fps 0"), 2, {"--fps 0: output.playback_rate: "});
        check_refusal(place.run("render --out moved --set output.shade=blue"), 3,
                      {"--set output.shade=blue"});
    }
    SECTION("frames without a state are refused") {
        check_refusal(place.run("render --out moved --frames 2:5"), 2,
                      {"the state of frame 4 is not kept", "kept: 4 frames from 0 to 3"});
    }
    SECTION("a damaged state is named") {
        std::string state = slurp(place / "moved/states/state_000002.bin");
        state[state.size() / 2] = static_cast<char>(state[state.size() / 2] ^ 1);
        spit(place / "moved/states/state_000002.bin", state);
        check_refusal(place.run("render --out moved --quiet"), 1, {"state_000002.bin: damaged"});
    }
    SECTION("a scene that is not the states' is refused") {
        check_refusal(place.run("render --out moved --quiet --set cloth.translate=[9,9,9] --set "
                                "cloth.mesh=moved/meshes/none.obj"),
                      3, {"none.obj"});
        spit(place / "moved/meshes/rest_000000.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
        check_refusal(place.run("render --out moved --quiet"), 1,
                      {"its cloth is not the one of the kept states"});
    }
}

TEST_CASE(
    "a run keeps the meshes of colliders and the textures of its scene, and tells where contact's time goes",
    "[cli]") {
    const Workplace place;
    spit(place / "sheet.toml", R"(version = 1

[[cloth]]
texture = "print.png"

[[collider]]
shape = "mesh"
mesh = "roof.obj"
center = [0, -2, 0]

[output]
size = [64, 48]
)");
    spit(place / "roof.obj", "v -1 0 -1\nv 1 0 -1\nv 0 0.3 1\nf 1 2 3\n");
    render::write_png({2, 1, {255, 0, 0, 255, 0, 255, 0, 255}}, place / "print.png");
    REQUIRE(place.run(base + "--frames 2 --no-video").code == 0);
    const nlohmann::json report = report_of(place, "o");
    double sum = 0;
    for (const char* part : {"detection", "assembly", "factorization", "conjugate_gradients", "line_search"})
        sum += report["contact_times_s"].at(part).get<double>();
    CHECK(sum > 0);
    CHECK(sum <= report["times_s"]["simulate"]);
    const std::string picture = slurp(place / "o/frames/frame_000001.png");
    for (const char* original : {"sheet.toml", "roof.obj", "print.png"}) fs::remove(place / original);
    fs::rename(place / "o", place / "moved");
    fs::remove_all(place / "moved/frames");
    CHECK(place.run("render --out moved --quiet --no-video").code == 0);
    CHECK(slurp(place / "moved/frames/frame_000001.png") == picture);
}

TEST_CASE("a contact sheet holds pictures of a run or of a scene", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 9").code == 0);
    const auto before = place.files("o");
    const Outcome outcome = place.run("sheet --out o --quiet --count 4 --file s.png");
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.out, Contains("4 pictures in ") && Contains("s.png"));
    CHECK(place.files("o") == before);
    const render::Image sheet = render::read_png(place / "s.png");
    CHECK(sheet.width > 2 * 64);
    CHECK(sheet.width < 2 * 64 + 30);
    CHECK(sheet.height > 2 * 48);
    // Four in a row are half as high.
    CHECK(place.run("sheet --out o --quiet --count 4 --columns 4 --file row.png").code == 0);
    CHECK(render::read_png(place / "row.png").height < 48 + 40);
    check_refusal(place.run("sheet --out o --frames 5:20"), 2, {"--frames 5:20", "kept: 9 frames"});
    check_refusal(place.run("sheet --out nowhere"), 1, {"nowhere: holds no run"});

    const Outcome scene = place.run("sheet --scene sheet.toml --frames 3 --quiet");
    CHECK(scene.code == 0);
    CHECK(fs::exists(place / "out/sheet/sheet.png"));
    // The next run into that folder takes it away: it would show another run.
    CHECK(place.run("simulate --scene sheet.toml --frames 2 --quiet").code == 0);
    CHECK_FALSE(fs::exists(place / "out/sheet/sheet.png"));
}

TEST_CASE("two runs stand beside each other in one movie", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate --scene sheet.toml --out a --quiet --frames 6").code == 0);
    REQUIRE(
        place.run("simulate --scene sheet.toml --out b --quiet --frames 9 --set cloth.resolution=8").code ==
        0);
    const Outcome outcome = place.run(
        "compare-video a b --file ab.mp4 --size 128x96 --labels fine,coarse --shade gap --caption --quiet");
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK_THAT(outcome.out, Contains("6 frames of 258x96 at 60 frames/s: ab.mp4"));
    CHECK(fs::exists(place / "ab.mp4"));
    CHECK_FALSE(fs::exists(place / "a/a.mp4"));
    check_refusal(place.run("compare-video a nowhere --file x.mp4"), 1, {"nowhere: holds no run"});
    CHECK_FALSE(fs::exists(place / "x.mp4"));
}

TEST_CASE("pictures that know the whole run are the same at once and redrawn, whole and in parts", "[cli]") {
    const Workplace place;
    const std::string wanted =
        "--shade stretch --curves energy,gap,iterations --caption --wireframe --motion-blur 2 --size 320x240 "
        "--set 'camera.frame=\"auto\"' --set camera.turntable=30 --quiet ";
    REQUIRE(place.run("--scene sheet.toml --frames 6 --out a " + wanted).code == 0);
    CHECK(fs::exists(place / "a/sheet.mp4"));
    const auto report = report_of(place, "a");
    CHECK(report["outcome"] == "complete");
    CHECK(report["output"]["images"] == 6);
    REQUIRE(place.run("simulate --scene sheet.toml --frames 6 --out b --quiet").code == 0);
    REQUIRE(place.run("render --out b --frames 3:5 " + wanted).code == 0);
    for (const char* name : {"frames/frame_000003.png", "frames/frame_000004.png"})
        CHECK(slurp(place / "a" / name) == slurp(place / "b" / name));
    // And differ from plain ones, which are as ever.
    REQUIRE(place.run("render --out b --frames 3:5 --size 320x240 --quiet").code == 0);
    CHECK(slurp(place / "a/frames/frame_000003.png") != slurp(place / "b/frames/frame_000003.png"));
}

TEST_CASE("an exported frame has every digit of its state", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 4").code == 0);
    const State state = pipeline::read_state(place / "o/states/state_000003.bin");
    const auto export_as = [&](const std::string& format) {
        const Outcome outcome =
            place.run("export --out o --frame 3 --format " + format + " --file m." + format);
        CHECK(outcome.code == 0);
        CHECK_THAT(outcome.out, Contains("m." + format));
        return slurp(place / ("m." + format));
    };
    SECTION("OBJ") {
        std::istringstream lines(export_as("obj"));
        std::string kind, x, y, z;
        int vertices = 0, faces = 0;
        for (std::string line; std::getline(lines, line);) {
            std::istringstream words(line);
            words >> kind >> x >> y >> z;
            if (kind == "v") {
                const double values[] = {std::stod(x), std::stod(y), std::stod(z)};
                CHECK(std::memcmp(values, state.positions.data() + 3 * vertices, sizeof values) == 0);
                ++vertices;
            }
            if (kind == "f") ++faces;
        }
        CHECK(vertices == 144);
        CHECK(faces == 242);
    }
    SECTION("PLY") {
        const std::string bytes = export_as("ply");
        // x y z as doubles, then normal and texture coordinates as floats
        constexpr std::size_t stride = 3 * sizeof(double) + 5 * sizeof(float);
        const std::size_t first = bytes.find("end_header\n") + 11;
        REQUIRE(bytes.size() > first + 144 * stride);
        for (std::size_t i = 0; i < 144; ++i)
            CHECK(std::memcmp(bytes.data() + first + i * stride, state.positions.data() + 3 * i,
                              3 * sizeof(double)) == 0);
    }
    SECTION("a sequence, its format from the extension") {
        const Outcome outcome = place.run("export --out o --frames 1:4 --file m.obj --quiet");
        CHECK(outcome.code == 0);
        CHECK(outcome.err.empty());
        CHECK(outcome.out == "3 frames as obj: m_000001.obj to m_000003.obj\n");
        CHECK_FALSE(fs::exists(place / "m.obj"));
        CHECK(slurp(place / "m_000003.obj") == export_as("obj"));
        CHECK(slurp(place / "m_000001.obj") != slurp(place / "m_000002.obj"));
    }
    SECTION("all that is kept") {
        CHECK(place.run("export --out o --file m.pvd --quiet").out == "4 frames as vtk: m.pvd\n");
        CHECK(place.run("export --out o --file m.npz --quiet").out == "4 frames as npz: m.npz\n");
    }
    SECTION("a cloth that is not there") {
        check_refusal(place.run("export --out o --cloth sleeve --file m.obj"), 2,
                      {"--cloth sleeve: the run has no cloth of this name; it has cloth"});
    }
    SECTION("a sequence with a frame that is not kept") {
        check_refusal(place.run("export --out o --frames 2:5 --file m.ply"), 2,
                      {"--frames 2:5: the state of frame 4 is not kept in o; kept: 4 frames from 0 to 3"});
        CHECK_FALSE(fs::exists(place / "m_000002.ply"));
    }
    SECTION("a frame that is not kept") {
        check_refusal(place.run("export --out o --frame 4 --format obj --file m.obj"), 2,
                      {"--frame 4: its state is not kept in o", "4 frames from 0 to 3"});
        CHECK_FALSE(fs::exists(place / "m.obj"));
    }
}

TEST_CASE("goldens: blessed, compared, and a change is told by exit code 6", "[cli]") {
    const Workplace place;
    check_refusal(place.run("compare sheet.toml --golden g --out o"), 6,
                  {"is missing", "render_cloth bless sheet"});
    const Outcome blessed = place.run("bless sheet.toml --golden g --out o");
    CHECK(blessed.code == 0);
    CHECK_THAT(blessed.out, Contains("nothing to compare with") && Contains("goldens written to g/sheet"));
    const Outcome same = place.run("compare sheet.toml --golden g --out o");
    CHECK(same.code == 0);
    CHECK_THAT(same.out,
               Contains("sheet: agrees (same build, states exact, same renderer, pictures exact)") &&
                   Contains("report: o/golden.html"));
    const Outcome other =
        place.run("compare sheet.toml --golden g --out o --set simulation.gravity=[0,-9.8,0]");
    CHECK(other.code == 6);
    CHECK_THAT(other.out, Contains("DIFFERS") && Contains("sheet: differs"));
    CHECK_THAT(other.err, Contains("render_cloth: sheet differs from its goldens, see o/golden.html") &&
                              Contains("render_cloth bless sheet"));
    const Outcome again = place.run("bless sheet.toml --golden g --out o");
    CHECK_THAT(again.out, Contains("old against new:") && Contains("sheet: agrees"));
}

TEST_CASE("the physics is checked by name, with parameters, a table and plots", "[cli]") {
    const Workplace place;
    const Outcome one = place.run("validate cantilever --gamma 0.5 --resolution 16");
    CHECK(one.code == 0);
    CHECK_THAT(one.out, Contains("measured") && Contains("H/W at Gamma 0.5") && Contains("good") &&
                            Contains("heavy elastica"));
    const Outcome plotted = place.run("validate space_order --plots p --markdown");
    CHECK(plotted.code == 0);
    CHECK_THAT(plotted.out, Contains("| check | quantity |") && Contains("| good |"));
    CHECK(place.files("p") == std::vector<std::string>{"space_order.svg"});
    check_refusal(place.run("validate cantilver"), 2, {"cantilver not in {cantilever,"});
    check_refusal(place.run("validate drape --gamma 3"), 2, {"validate drape: has no --gamma"});
    check_refusal(place.run("validate --gamma 3"), 2, {"--gamma: give the check that it belongs to"});
    check_refusal(place.run("validate cantilever --gamma -1"), 2, {"--gamma: Value -1 not in range 0.001"});
    check_refusal(place.run("validate cantilever --resolution 2"), 2,
                  {"--resolution: Value 2 not in range 4 to 2000"});
    check_refusal(place.run("validate drape --fabric tweed"), 2, {"--fabric: tweed not in {cotton,"});
}

TEST_CASE("what was mended in a mesh is told once, kept in the report, and not done again", "[cli]") {
    const Workplace place;
    spit(place / "two.obj",
         "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nv 0.1 0 0\nv 0.2 0 0\nv 0.2 0.1 0\nv 0.1 0.1 0\n"
         "f 1 2 3 4\nf 5 8 7 6\n");
    spit(place / "two.toml",
         "version = 1\n[[cloth]]\nmesh = \"two.obj\"\n[[pin]]\nvertices = [7]\n[output]\nsize = [64, 48]\n");
    const Outcome made = place.run("--scene two.toml --out o --frames 2 --quiet");
    CHECK(made.code == 0);
    for (const char* note :
         {"render_cloth: note: cloth[0].mesh: ", "two.obj: 2 faces of more than three corners cut",
          "two.obj: 2 doubled vertices joined", "two.obj: 2 triangles of 4 turned over"})
        CHECK_THAT(made.err, Contains(note));
    CHECK(report_of(place, "o")["notes"].size() == 3);
    // The kept mesh is the mended one, and the kept pin has its number.
    CHECK_THAT(slurp(place / "o/meshes/rest_000000.obj"), Contains("f 2 6 3\nf 2 5 6\n"));
    CHECK_THAT(slurp(place / "o/scene.toml"), Contains("vertices = [2]"));
    const Outcome redrawn = place.run("render --out o --quiet");
    CHECK(redrawn.code == 0);
    CHECK(redrawn.err.empty());
}
