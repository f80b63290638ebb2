// What the program refuses before it begins, and what it tells of itself.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "apps/workplace.h"
#include "base/text.h"
#include "pipeline/formats/exporters.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("bad arguments are refused with what would be right, and leave nothing behind", "[cli]") {
    const Workplace place;
    spit(place / "file", "x");
    const auto before = place.files();
    const auto formats = pipeline::export_format_names();
    struct Case {
        const char* arguments;
        std::vector<std::string> parts;
    };
    const std::vector<Case> cases = {
        {"", {"--scene is missing", "render_cloth list"}},
        {"--frames 3", {"--scene is missing"}},
        {"simulate", {"--scene is missing"}},
        {"frobnicate", {"unknown verb \"frobnicate\"", "known: run, simulate", "compare"}},
        {"simulat", {"did you mean \"simulate\"?"}},
        {"simulate sheet.toml", {"not expected: sheet.toml", "render_cloth simulate --help"}},
        {"run simulate", {"not expected: simulate"}},
        {"--scene sheet.toml --version", {"not expected: --version"}},
        {"list clothes", {"clothes not in {scenes,fabrics,keys"}},
        {"list fabrics coton", {"no fabric \"coton\"; did you mean \"cotton\"?", "known: cotton, denim"}},
        {"list scenes drape_sphere", {"list scenes takes no name"}},
        {"list --sources", {"no --sources"}},
        {"list formats obj", {"list formats takes no name"}},
        {"list fabrics cotton silk", {"not expected: silk"}},
        {"--scene sheet.toml --frobnicate", {"not expected: --frobnicate", "--help"}},
        {"simulate --scene sheet.toml --frobnicate 3", {"--frobnicate"}},
        {"--scene sheet.toml --frames", {"--frames: 1 required N missing", "--help"}},
        {"--scene sheet.toml --frames 2 --frames 3", {"--frames", "At Most 1"}},
        {"--scene sheet.toml --frames 0", {"--frames 0: output.frames: is 0; must be 1 … "}},
        {"--scene sheet.toml --frames -3", {"--frames -3: output.frames: is -3; must be 1 … "}},
        {"--scene sheet.toml --frames many", {"--frames many: output.frames: ", "must be a whole number"}},
        {"--scene sheet.toml --frames 1.5", {"--frames 1.5", "must be a whole number"}},
        {"--scene sheet.toml --frames 99999999999999", {"--frames 99999999999999", "must be 1 … "}},
        {"--scene sheet.toml --size 0x0", {"--size 0x0: output.size: ", "must be 16 … 8192"}},
        {"--scene sheet.toml --size 8193x720", {"--size 8193x720", "must be 16 … 8192"}},
        {"--scene sheet.toml --size -64x48", {"--size -64x48", "must be 16 … 8192"}},
        {"--scene sheet.toml --size 640", {"--size 640", "must be \"WIDTHxHEIGHT\""}},
        {"--scene sheet.toml --size 640x", {"--size 640x", "must be \"WIDTHxHEIGHT\""}},
        {"--scene sheet.toml --size 640x480x3", {"--size 640x480x3", "must be \"WIDTHxHEIGHT\""}},
        {"--scene sheet.toml --fps nan", {"--fps nan", "must be a finite number"}},
        {"--scene sheet.toml --fps inf", {"--fps inf", "must be a finite number"}},
        {"--scene sheet.toml --fps 0", {"--fps 0", "must be 0.001 … 1000000 1/s"}},
        {"--scene sheet.toml --fps -24", {"--fps -24", "must be 0.001 … 1000000 1/s"}},
        {"--scene sheet.toml --fps fast", {"--fps fast", "must be a number"}},
        {"--scene sheet.toml --set output.playback_rate=30 --fps 0.001",
         {"--fps 0.001: output.playback_rate: ", "must be 0.01 … 1000"}},
        {"--scene sheet.toml --threads 0", {"--threads: Value 0 not in range 1 to 1024"}},
        {"--scene sheet.toml --threads two", {"--threads: Value two not in range 1 to 1024"}},
        {"--scene sheet.toml --gl vulkan", {"--gl: vulkan not in {auto,egl,osmesa}"}},
        {"--scene sheet.toml --frames 2 --out file", {"--out file", "is a file; give a folder"}},
        {"--scene sheet.toml --set nonsense", {"--set nonsense", "KEY=VALUE"}},
        {"--scene sheet.toml --set =3", {"--set =3", "KEY=VALUE"}},
        {"compare sheet.toml --set nonsense", {"--set nonsense", "KEY=VALUE"}},
        {"render", {"--out is required"}},
        {"render --out o --frames 3", {"--frames 3", "A:B"}},
        {"render --out o --frames 3:3", {"--frames 3:3", "A < B"}},
        {"render --out o --frames -1:3", {"--frames -1:3", "0 <= A"}},
        {"encode", {"--out is required"}},
        {"export", {"--out is required"}},
        {"export --out o --frame 1 --frames 0:2 --file f.obj", {"give either --frame K", "or --frames A:B"}},
        {"export --out o --frames 3 --file f.obj", {"--frames 3: give A:B"}},
        {"export --out o --frames 0:2 --format obj --file .", {"--file .: is a folder", "./sheet.obj"}},
        {"export --out o --frame 1 --file f.txt",
         {"--file f.txt: its extension is that of no mesh format; give --format, one of " + join(formats)}},
        {"export --out o --frame x --format obj --file f", {"--frame: Value x not in range 0 to "}},
        {"export --out o --frame 1 --format clay --file f",
         {"--format: clay not in {" + join(formats, ",") + "}"}},
        {"export --out o --frame 1 --format obj", {"--file is required"}},
        {"--scene sheet.toml --shade strech",
         {"--shade strech", "did you mean \"stretch\"?", "stretch, bending, kinetic, gap, strain_rate"}},
        {"--scene sheet.toml --shade gap --shade-range 1", {"--shade-range 1", "must be two entries"}},
        {"--scene sheet.toml --shade gap --shade-range 2:1", {"--shade-range 2:1", "output.shade_range"}},
        {"--scene sheet.toml --ids 3", {"--ids 3", "must be [x, y] or [x, y, radius]"}},
        {"--scene sheet.toml --ids 3,4,-1", {"--ids 3,4,-1", "output.ids"}},
        {"--scene sheet.toml --curves energy,heat",
         {"--curves energy,heat", "is \"heat\"; must be one of energy, kinetic, stretch, gap"}},
        {"--scene sheet.toml --motion-blur 0", {"--motion-blur 0: output.motion_blur: ", "must be 1 … 64"}},
        {"sheet", {"--out is missing", "--scene"}},
        {"sheet --out o --count 0", {"--count: Value 0 not in range 1 to 1000"}},
        {"sheet --out o --columns x", {"--columns: Value x not in range 1 to 1000"}},
        {"sheet --out o --frames 4", {"--frames 4", "A:B"}},
        {"compare-video", {"runs is required", "render_cloth compare-video --help"}},
        {"compare-video a --file f.mp4", {"runs: At least 2 required but received 1"}},
        {"compare-video a b c --file f.mp4", {"runs: At Most 2 required but received 3"}},
        {"compare-video a b", {"--file is required"}},
        {"compare-video a b --file f.png", {"--file f.png", "name.mp4"}},
        {"compare-video a b --file f.mp4 --labels one", {"--labels one", "two texts"}},
        {"compare", {"compare: scene is required"}},
        {"bless", {"bless: scene is required"}},
    };
    for (const Case& c : cases) {
        INFO("render_cloth " << c.arguments);
        check_refusal(place.run(c.arguments), 2, c.parts);
        CHECK(place.files() == before);
    }
}

TEST_CASE("bad scenes and meshes are refused before anything is written", "[cli]") {
    const Workplace place;
    spit(place / "empty.obj", "");
    spit(place / "garbage.obj", "this is no mesh\n\x01\x02\x03");
    spit(place / "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    spit(place / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    spit(place / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    spit(place / "nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    spit(place / "pinned.toml", slurp(place / "sheet.toml") + "\n[[pin]]\nbox = [[5, 5, 5], [6, 6, 6]]\n");
    spit(place / "broken.toml", "version = 1\n[simulation\n");
    const auto before = place.files();
    struct Case {
        std::string arguments;
        std::vector<std::string> parts;
    };
    const std::vector<Case> cases = {
        {"--scene drape_spere", {"drape_spere", "drape_sphere"}},
        {"--scene none.toml", {"none.toml"}},
        {"--scene broken.toml", {"broken.toml", "2"}},
        {"--scene pinned.toml", {"pin[0]"}},
        {"--scene sheet.toml --set cloth.densty=1", {"densty"}},
        {"--scene sheet.toml --set simulation.time_step=fast", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=0", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=-0.01", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=nan", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=inf", {"time_step"}},
        {"--scene sheet.toml --set simulation.frame_rate=0", {"frame_rate"}},
        {"--scene sheet.toml --set 'cloth.resolution=[1, 12]'", {"resolution"}},
        {"--scene sheet.toml --set 'cloth.resolution=[-4, 12]'", {"resolution"}},
        {"--scene sheet.toml --set 'cloth.size=[0, 1]'", {"size"}},
        {"--scene sheet.toml --set 'cloth.translate=[0, nan, 0]'", {"translate"}},
        {"--scene sheet.toml --set collider.radius=-1", {"radius"}},
        {"--scene sheet.toml --set output.frames=0", {"frames"}},
        {"--scene sheet.toml --set cloth.mesh=none.obj", {"none.obj"}},
        {"--scene sheet.toml --set cloth.mesh=empty.obj", {"empty.obj"}},
        {"--scene sheet.toml --set cloth.mesh=garbage.obj", {"garbage.obj"}},
        {"--scene sheet.toml --set cloth.mesh=points.obj", {}},
        {"--scene sheet.toml --set cloth.mesh=flat.obj", {"triangle 0", "degenerate"}},
        {"--scene sheet.toml --set cloth.mesh=range.obj", {}},
        {"--scene sheet.toml --set cloth.mesh=nan.obj", {}},
    };
    for (const Case& c : cases) {
        INFO("render_cloth " << c.arguments);
        check_refusal(place.run(c.arguments + " --out o"), 3, c.parts);
        CHECK(place.files() == before);
    }
}

TEST_CASE("folders that cannot be used are named with the reason", "[cli]") {
    const Workplace place;
    spit(place / "file", "x");
    check_refusal(place.run("--scene sheet.toml --frames 2 --out file/below"), 1,
                  {"cannot write to the folder file/below", "Not a directory"});
    check_refusal(place.run("render --out nowhere"), 1, {"nowhere: holds no run", "render_cloth simulate"});
    check_refusal(place.run("export --out nowhere --frame 0 --format obj --file f.obj"), 1, {"holds no run"});
    check_refusal(place.run("export --out nowhere --frames 0:2 --file f.obj"), 1, {"holds no run"});
    CHECK_FALSE(fs::exists(place / "nowhere"));
}

TEST_CASE("the program tells of itself", "[cli]") {
    const Workplace place;
    const Outcome version = place.run("--version");
    CHECK(place.run("version").out == version.out);
    CHECK(version.code == 0);
    for (const char* part :
         {"render_cloth ", "compiler: ", "build: ", "renderer: ", "encoder: ffmpeg version"})
        CHECK_THAT(version.out, Contains(part));
    CHECK_THAT(version.out, !Contains("not available"));
    const Outcome help = place.run("--help");
    CHECK(help.code == 0);
    for (const char* part : {"--scene", "--frames", "--set", "--no-video", "simulate", "render", "export",
                             "compare", "bless", "list"})
        CHECK_THAT(help.out, Contains(part));
    for (const char* verb : {"run", "simulate", "render", "encode", "export", "compare", "bless", "list",
                             "sheet", "compare-video"})
        CHECK(place.run(std::string(verb) + " --help").code == 0);
    const Outcome list = place.run("list");
    CHECK(list.code == 0);
    const Outcome keys = place.run("list keys");
    CHECK(keys.code == 0);
    CHECK_THAT(keys.out,
               Contains("[[collider]]") && Contains("  contact_offset     number, 0 … 1000000 [m]"));
    for (const char* scene : {"seed_sheet", "seed_kick", "seed_drag", "drape_sphere", "hanging_sheet"})
        CHECK_THAT(list.out, Contains(scene));
    CHECK(place.run("list scenes").out == list.out);
    CHECK_THAT(place.run("list --markdown").out,
               Contains("| `seed_sheet` | ") && Contains("| vertices | steps |"));
    const Outcome schema = place.run("list schema");
    CHECK(schema.code == 0);
    CHECK(nlohmann::json::parse(schema.out).at("properties").contains("collider"));
    check_refusal(place.run("list keys --markdown"), 2,
                  {"list keys takes no --markdown; scenes and fabrics do"});
    const Outcome formats = place.run("list formats"), exporting = place.run("export --help");
    CHECK(formats.code == 0);
    CHECK(formats.out == pipeline::export_format_list());
    CHECK_THAT(exporting.out, Contains("--format NAME:{" + join(pipeline::export_format_names(), ",") + "}"));
    const Outcome fabrics = place.run("list fabrics");
    CHECK(fabrics.code == 0);
    for (const char* part : {"[g/m²]", "[N/m]", "[µN m]", "cotton", "paper", "--sources"})
        CHECK_THAT(fabrics.out, Contains(part));
    const Outcome silk = place.run("list fabrics silk");
    CHECK(silk.code == 0);
    CHECK_THAT(silk.out,
               Contains("density") && Contains("0.082 kg/m²") && Contains("19 momme") && !Contains("wool:"));
    const Outcome sources = place.run("list fabrics --sources");
    CHECK_THAT(sources.out, Contains("Kawabata") && Contains("wool:") && Contains("[µN m]"));
    CHECK(place.files() == std::vector<std::string>{"sheet.toml"});
}
