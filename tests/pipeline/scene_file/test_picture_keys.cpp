// The keys of scene files that move the camera and draw over pictures.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_text.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;

namespace {

const std::string full = R"([camera]
position = [0, 1, 3]
turntable = -20
path = [
  { time = 0 },
  { time = 1.5, position = [1, 1, 2], target = [0, 0.25, 0], field_of_view = 25 },
]
[output]
caption = "{scene} at {time}"
shade = "strain_rate"
shade_range = [0, 12.5]
wireframe = true
ids = [320, 200, 25]
curves = ["stretch", "energy"]
motion_blur = 5
shutter = 0.25
)";

void check_full(const SceneFile& f) {
    CHECK(f.camera.position == Vec3(0, 1, 3));
    CHECK(f.camera.turntable == -20);
    CHECK(f.camera.framing == Framing::fixed);
    REQUIRE(f.camera.path.size() == 2);
    CHECK(f.camera.path[0].time == 0);
    CHECK(!f.camera.path[0].position);
    CHECK(!f.camera.path[0].field_of_view);
    CHECK(f.camera.path[1].time == 1.5);
    CHECK(f.camera.path[1].position == Vec3(1, 1, 2));
    CHECK(f.camera.path[1].target == Vec3(0, 0.25, 0));
    CHECK(f.camera.path[1].field_of_view == 25.0);
    CHECK(f.annotation.caption == "{scene} at {time}");
    CHECK(f.annotation.shade == VertexField::strain_rate);
    CHECK(f.annotation.shade_range == std::array<double, 2>{0, 12.5});
    CHECK(f.annotation.wireframe);
    REQUIRE(f.annotation.ids);
    CHECK(f.annotation.ids->x == 320);
    CHECK(f.annotation.ids->y == 200);
    CHECK(f.annotation.ids->radius == 25);
    CHECK(f.annotation.curves == std::vector<Curve>{Curve::stretch, Curve::energy});
    CHECK(f.annotation.motion_blur == 5);
    CHECK(f.annotation.shutter == 0.25);
}

}  // namespace

TEST_CASE("without its keys nothing is drawn over pictures, and the camera rests", "[picture_keys]") {
    const SceneFile f = parse(sheet());
    CHECK(!f.annotation.caption);
    CHECK(!f.annotation.shade);
    CHECK(!f.annotation.wireframe);
    CHECK(!f.annotation.ids);
    CHECK(f.annotation.curves.empty());
    CHECK(f.annotation.motion_blur == 1);
    CHECK(f.camera.path.empty());
    CHECK(f.camera.turntable == 0);
    CHECK(f.camera.framing == Framing::fixed);
}

TEST_CASE("every key of pictures reaches its field, also out of the resolved text", "[picture_keys]") {
    const SceneFile f = parse(sheet(full));
    check_full(f);
    check_full(parse(f.resolved()));
    CHECK(parse(sheet("[output]\ncaption = true\n")).annotation.caption == default_caption);
    CHECK(!parse(sheet("[output]\ncaption = false\n")).annotation.caption);
    CHECK(parse(sheet("[output]\nids = [3, 4]\n")).annotation.ids->radius == 0);
    CHECK(parse(sheet("[camera]\nframe = \"auto\"\n")).camera.framing == Framing::automatic);
    const SceneFile set =
        parse(sheet(), {"output.shade=gap", "output.shade_range=[-0.01, 0.1]", "output.curves=[\"gap\"]",
                        "camera.path=[{ time = 2, field_of_view = 50 }]", "output.caption=frame {frame}"});
    CHECK(set.annotation.shade == VertexField::gap);
    CHECK(set.annotation.curves == std::vector<Curve>{Curve::gap});
    CHECK(set.camera.path[0].field_of_view == 50.0);
    CHECK(set.annotation.caption == "frame {frame}");
}

TEST_CASE("wrong values are refused with their place and what would be right", "[picture_keys]") {
    const std::vector<std::array<std::string, 2>> cases = {
        {"[camera]\nturntable = 4000\n",
         "s.toml:4:13: camera.turntable: is 4000; must be -3600 … 3600 degree/s"},
        {"[camera]\nframe = \"all\"\n", "camera.frame: is \"all\"; must be one of fixed, auto"},
        {"[camera]\nframe = \"auto\"\npath = [{ time = 0 }]\n",
         "s.toml:4:9: camera.frame: is \"auto\" beside a path, which says where the camera is; give one of "
         "the two"},
        {"[camera]\npath = [{ position = [1, 1, 1] }]\n", "s.toml:4:9: camera.path[0]: has no time [s]"},
        {"[camera]\npath = [{ time = 0 }, { time = 0 }]\n",
         "camera.path[1].time: is 0; must be later than the key before, 0 s"},
        {"[camera]\npath = [{ time = 0, positon = [1, 1, 1] }]\n",
         "camera.path[0].positon: unknown key; did you mean \"position\" [m]?"},
        {"[camera]\npath = [{ time = 0, field_of_view = 170 }]\n",
         "camera.path[0].field_of_view: is 170; must be 1 … 160 degree"},
        {"[camera]\npath = [{ time = 0, position = [0, 0, 0] }]\n",
         "camera.path[0]: has its target where it stands; it must lie elsewhere"},
        {"[camera]\npath = [{ time = 0, position = [0, 4, 0] }]\n",
         "camera.path[0]: looks along camera.up; it must look across it"},
        {"[camera]\npath = [3]\n",
         "camera.path[0]: is a whole number; must be { time, position, target, field_of_view }"},
        {"[output]\ncaption = \"at {tine}\"\n",
         "s.toml:4:11: output.caption: has \"{tine}\"; known: {scene}, {time}, {frame}, {description}"},
        {"[output]\ncaption = \"{\"\n", "output.caption: has \"{\"; known: {scene}"},
        {"[output]\ncaption = 3\n", "output.caption: is a whole number; must be true, false or a text"},
        {"[output]\nshade = \"strech\"\n", "output.shade: is \"strech\"; did you mean \"stretch\"?"},
        {"[output]\nshade_range = [0, 1]\n",
         "output.shade_range: belongs to output.shade; name what is shown in colours"},
        {"[output]\nshade = \"gap\"\nshade_range = [1, 1]\n",
         "s.toml:5:15: output.shade_range: is [1, 1]; the second must be the greater"},
        {"[output]\nwireframe = 1\n", "output.wireframe: is a whole number; must be true or false"},
        {"[output]\nids = [1]\n", "output.ids: has 1 entries; must be [x, y] or [x, y, radius] [pixel]"},
        {"[output]\nids = [1, 2, -3]\n", "output.ids: has the radius -3; must be at least 0 [pixel]"},
        {"[output]\ncurves = [\"energy\", \"enery\"]\n",
         "s.toml:4:21: output.curves[1]: is \"enery\"; did you mean \"energy\"?"},
        {"[output]\ncurves = [\"gap\", \"gap\"]\n", "output.curves[1]: stands there twice"},
        {"[output]\ncurves = \"gap\"\n", "output.curves: is a string; must be a list of names"},
        {"[output]\nmotion_blur = 0\n", "output.motion_blur: is 0; must be 1 … 64"},
        {"[output]\nshutter = 2\n", "output.shutter: is 2; must be 0.01 … 1"},
    };
    for (const auto& [text, message] : cases) {
        INFO(text);
        CHECK_THAT(refusal(sheet(text)), Contains(message));
    }
    CHECK_THAT(refusal(sheet(), {"output.shade=strech"}),
               Contains("--set output.shade=strech: output.shade: is \"strech\"; did you mean \"stretch\"?"));
}
