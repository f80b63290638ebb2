// Every key of scene files, by walking the schema: it is read, written and compared; the list of keys and the
// JSON Schema have it.

#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/formats/mesh_cache_file.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/ply.h"
#include "pipeline/scene_file/scene_text.h"
#include "pipeline/scene_file/tables.h"
#include "render/image/image.h"
#include "sim/scene/mesh.h"
#include "support/json_schema.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

// ---------------------------------------------------------------- a value for each key

/// A value, as the writer writes it, that a JSON Schema of the scene's allows and that is not `old`; `n`
/// tells numbers apart.
std::string value_of(const Json& schema, int n, const std::string& old = "") {
    if (schema.contains("anyOf")) return value_of(schema["anyOf"].back(), n);
    if (schema.contains("enum")) {
        const std::string first = schema["enum"][0].dump();
        return first == old ? schema["enum"][1].dump() : first;
    }
    const Json& type = schema["type"];
    if (type == "boolean") return old == "true" ? "false" : "true";
    if (type == "string" || type.is_array()) return "\"text " + std::to_string(n) + "\"";
    if (type == "integer" || type == "number") {
        const double low = schema.value("minimum", schema.value("exclusiveMinimum", 0.0));
        const double high = schema.value("maximum", schema.value("exclusiveMaximum", low + 8.0));
        const bool whole = type == "integer";
        const double value = low + (high - low) * (0.25 + 0.03125 * (n % 16));
        if (!whole) return Value<double>::write(value);
        const std::string text = std::to_string(static_cast<int>(value) + 1);
        return text == old ? std::to_string(static_cast<int>(low)) : text;
    }
    if (type == "object") {
        std::string text;
        for (const auto& [key, entry] : schema["properties"].items())
            text += (text.empty() ? "{ " : ", ") + key + " = " + value_of(entry, ++n);
        return text + " }";
    }
    REQUIRE(type == "array");
    std::string text;
    for (int i = 0; i < schema.value("maxItems", 1); ++i)
        text += (i ? ", " : "[") + value_of(schema["items"], n + i);
    return text + "]";
}

/// What a key needs beside itself, and a value where not any will do.
struct Setting {
    Overrides needs{};
    std::string value{};
    std::string scene{};  ///< instead of the scene that all others are set in
};

const std::string all_tables = R"(version = 1
[[cloth]]
resolution = 3
fabric = { young_modulus = 1e4, poisson_ratio = 0.3 }
[[collider]]
[[pin]]
nearest = [0, 0, 0]
[[seam]]
first = { edge = "left" }
second = { edge = "right" }
[[drag]]
path = [[0, 1, 1], [1, 2, 2]]
[[event]]
integrator = "tr_bdf2"
[ground]
)";
const std::string two_cloths = "version = 1\n[[cloth]]\nname = \"a\"\n[[cloth]]\nname = \"b\"\n";

std::map<std::string, Setting> settings(const fs::path& folder) {
    const std::string mesh = (folder / "rest.ply").string(),
                      event =
                          "version = 1\n[[cloth]]\n[[collider]]\nname = \"ball\"\n[[collider]]\n[[event]]\n";
    const std::string cache = (folder / "rest.npz").string();
    const Overrides body{"collider.shape=mesh", "collider.mesh=" + mesh},
        bending{"collider.shape=mesh", "collider.mesh=" + mesh, "collider.cache=" + cache};
    const Overrides moduli{"cloth.fabric.mu=2.5", "cloth.fabric.lambda=2.5"};
    // What follows a cloth's size where it is not said.
    const std::string lengths =
        "contact_thickness = 1e-3\nhem = 2e-3\n[simulation]\ncontact_activation = 1e-3\n";
    // A cloth of two parts with texture coordinates.
    const std::string parts = (folder / "parts.obj").string(),
                      cut = sheet("name = \"a\"\nmesh = \"" + parts + "\"\n"),
                      part =
                          cut +
                          "[[part]]\nname = \"low\"\nfabric = { young_modulus = 1e4, poisson_ratio = 0.3 }\n";
    std::map<std::string, Setting> all{
        {"cloth.edge_length", {.needs = {"cloth.mesh=" + mesh}, .scene = sheet(lengths)}},
        {"cloth.rest", {.needs = {"cloth.mesh=" + parts}, .value = "\"uv\"", .scene = sheet(lengths)}},
        {"cloth.uv_scale",
         {.needs = {"cloth.mesh=" + parts, "cloth.rest=uv"}, .value = "1.01", .scene = sheet(lengths)}},
        {"part.cloth",
         {.value = "\"b\"",
          .scene = cut + "[[cloth]]\nname = \"b\"\nmesh = \"" + parts + "\"\n[[part]]\nname = \"low\"\n"}},
        {"part.name", {.value = "\"high\"", .scene = part}},
        {"pin.part", {.value = "\"high\"", .scene = cut + "[[pin]]\nnearest = [0, 0, 0]\n"}},
        {"pin.collider",
         {.value = "\"ball\"",
          .scene = "version = 1\n[[cloth]]\n[[collider]]\nname = \"ball\"\n[[pin]]\nnearest = [0, 0, 0]\n"}},
        {"seam.first.part",
         {.value = "\"high\"",
          .scene = cut + "[[seam]]\nfirst = { part = \"low\" }\nsecond = { part = \"high\" }\n"}},
        {"seam.second.part",
         {.value = "\"low\"",
          .scene = cut + "[[seam]]\nfirst = { part = \"low\" }\nsecond = { part = \"high\" }\n"}},
        {"simulation.integrator", {.value = "\"tr_bdf2\""}},
        {"simulation.contact", {.value = "\"penalty\""}},
        {"cloth.name", {.scene = sheet()}},
        {"cloth.size", {.scene = sheet(lengths)}},
        {"cloth.radius", {.needs = {"cloth.radius=0.5"}, .scene = sheet(lengths)}},
        {"air.lift", {.needs = {"air.drag=1000"}}},
        {"cloth.rings", {.needs = {"cloth.radius=0.5"}, .scene = sheet()}},
        {"cloth.mesh", {.value = "\"" + mesh + "\"", .scene = sheet()}},
        {"cloth.units", {.needs = {"cloth.mesh=" + mesh}, .value = "\"cm\"", .scene = sheet(lengths)}},
        {"cloth.weld", {.needs = {"cloth.mesh=" + mesh}, .scene = sheet()}},
        {"cloth.pose", {.value = "\"" + mesh + "\""}},
        {"cloth.texture", {.value = "\"" + (folder / "print.png").string() + "\""}},
        {"cloth.fabric.membrane", {.value = "\"neo_hookean\""}},
        {"cloth.fabric.young_weft",
         {.needs = {"cloth.fabric.membrane=st_venant_kirchhoff", "cloth.fabric.young_modulus=1e15"}}},
        {"cloth.fabric.shear_modulus", {.needs = {"cloth.fabric.membrane=st_venant_kirchhoff"}}},
        {"cloth.fabric.mu", {.needs = moduli}},
        {"cloth.fabric.lambda", {.needs = moduli, .value = "7.5"}},
        {"cloth.fabric.bending_model", {.value = "\"hinges\""}},
        {"cloth.fabric.yield_curvature", {.needs = {"cloth.fabric.bending_model=hinges"}}},
        {"collider.spin", {.needs = {"collider.center=[0, 0, 9]"}}},  // away from the pin
        {"collider.shape", {.value = "\"capsule\""}},
        {"collider.mesh",
         {.needs = {"collider.shape=mesh", "collider.mesh=" + (folder / "print.ply").string()},
          .value = "\"" + mesh + "\""}},
        {"collider.units", {.needs = {"collider.shape=mesh", "collider.mesh=" + mesh}, .value = "\"mm\""}},
        {"collider.cache", {.needs = body, .value = "\"" + cache + "\""}},
        {"collider.cache_start", {.needs = bending}},
        {"collider.cache_speed", {.needs = bending}},
        {"collider.cache_loop", {.needs = bending}},
        {"collider.cache_rate", {.needs = bending}},
        {"pin.cloth", {.value = "\"b\"", .scene = two_cloths + "[[pin]]\nedge = \"top\"\n"}},
        {"pin.vertices", {.value = "[4, 2]"}},
        {"pin.box", {.value = "[[-9.0, -8.0, -7.0], [6.0, 5.0, 4.0]]"}},
        {"seam.first.vertices", {.value = "[0, 3, 6]"}},
        {"seam.first.box", {.value = "[[-0.6, -0.6, -0.1], [-0.4, 0.6, 0.1]]"}},
        {"seam.first.greatest", {.value = "\"-x\""}},
        {"seam.first.edge", {.value = "\"top\""}},
        {"seam.first.nearest", {.needs = {"seam.first.nearest=[9, 9, 9]", "seam.second.nearest=[9, 9, 9]"}}},
        {"drag.path", {.value = "[[0.5, 3.0, 4.0], [0.75, 5.0, 6.0]]"}},
        {"event.collider", {.needs = {"event.collider=1"}, .value = "\"ball\"", .scene = event}},
        {"event.action", {.needs = {"event.collider=ball"}, .value = "\"off\"", .scene = event}},
        {"event.integrator", {.needs = {"simulation.contact=penalty"}, .value = "\"toggle\""}},
        {"camera.path",
         {.value = "[{ time = 0.5, position = [0.1, 0.2, 0.3], target = [3.0, 0.5, 1.0], "
                   "field_of_view = 20.0 }]"}},
        {"cloth.resolution", {.value = "[5, 7]"}},
        {"output.ids", {.value = "[3.0, 4.0, 5.0]"}},
        {"camera.frame", {.value = "\"auto\""}},
        {"expect.min_gap", {.value = "0.0005"}},
        {"output.shade_range", {.needs = {"output.shade=gap"}, .value = "[-0.25, 0.5]"}},
    };
    // A part's fabric is as a cloth's.
    SceneFile each = scene_of_each();
    for (const Table& table : tables_of(each, each.files)) {
        if (table.name != "part.fabric") continue;
        for (const Field& field : table.fields) {
            const auto cloth = all.find("cloth.fabric." + field.key);
            Setting own = cloth == all.end() ? Setting{} : cloth->second;
            for (Override& need : own.needs)
                need = Override("part" + need.setting.substr(std::string("cloth").size()));
            own.scene = part;
            all["part.fabric." + field.key] = own;
        }
    }
    for (const char* side : {"seam.first.", "seam.second."}) {
        all[std::string(side) + "cloth"] = {
            .value = "\"b\"",
            .scene = two_cloths + "[[seam]]\nfirst = { edge = \"left\" }\nsecond = { edge = \"right\" }\n"};
    }
    for (const char* key : {"vertices", "box", "greatest", "edge", "nearest"}) {
        all["seam.second." + std::string(key)] = all["seam.first." + std::string(key)];
    }
    return all;
}

/// Checks that `set` differs from `base` in the one key, which has the value, and in keys whose place it
/// takes or that go with it.
void check_only(SceneFile& base, SceneFile& set, const std::string& key, const std::string& value) {
    const Tables before = tables_of(base, base.files), after = tables_of(set, set.files);
    REQUIRE(before.size() == after.size());
    auto b = before.begin();
    for (const Table& table : after) {
        for (std::size_t i = 0; i < table.fields.size(); ++i) {
            const Field &f = table.fields[i], &g = b->fields[i];
            const std::string old = g.applies ? g.write() : "", now = f.applies ? f.write() : "";
            if (table.path + "." + f.key == key) {
                CHECK(now == value);
                CHECK(old != now);
            } else if (now != old) {
                INFO(table.path << "." << f.key << " was " << old << ", is " << now);
                CHECK((now.empty() || !g.applies));  // a key of a mesh is there where a mesh is
            }
        }
        ++b;
    }
}

}  // namespace

TEST_CASE("every key is read into its own place, written, and read back to the bit", "[scene_file]") {
    const TemporaryFolder folder;
    const MeshData rest = make_grid({.resolution = {3, 3}});
    spit(folder / "rest.ply", ply_bytes(rest));
    spit(folder / "print.ply", ply_bytes(rest));
    MeshData parts = rest;
    parts.parts = {{"high", {4, 5, 6, 7}}, {"low", {0, 1, 2, 3}}};
    parts.uv.resize(24, 2);
    for (Eigen::Index i = 0; i < 24; ++i)
        parts.uv.row(i) = rest.positions.row(rest.triangles(i / 3, static_cast<int>(i % 3))).head<2>();
    spit(folder / "parts.obj", obj_text(parts));
    write_mesh_cache({{rest.positions, rest.positions}, {}, {}}, folder / "rest.npz");
    render::write_png({2, 1, {255, 0, 0, 255, 0, 255, 0, 255}}, folder / "print.png");
    const std::map<std::string, Setting> special = settings(folder.path());
    SceneFile each = scene_of_each();
    int n = 0;
    std::size_t used = 0;
    for (const Table& table : tables_of(each, each.files)) {
        for (const Field& field : table.fields) {
            if (field.key == "version") continue;  // there is one
            const std::string name = table.name + (table.name.empty() ? "" : ".") + field.key;
            CAPTURE(name);
            const auto found = special.find(name);
            used += found != special.end();
            const Setting setting = found == special.end() ? Setting{} : found->second;
            const std::string text = setting.scene.empty() ? all_tables : setting.scene;
            const std::string value = setting.value.empty()
                                          ? value_of(Json::parse(field.schema), ++n, field.write())
                                          : setting.value;
            Overrides overrides = setting.needs;
            SceneFile base = parse(text, overrides);
            overrides.push_back(name + "=" + value);
            SceneFile set = parse(text, overrides);
            check_only(base, set, table.path + "." + field.key, value);
            if (!field.content) CHECK(difference(base, set) != "");
            INFO(set.resolved());
            const SceneFile again = parse(set.resolved());
            CHECK(difference(again, set) == "");
            CHECK(again.resolved() == set.resolved());
        }
    }
    CHECK(used == special.size());
    CHECK(n + used > 100);
}

TEST_CASE("scenes that differ in what a file holds differ", "[scene_file]") {
    const SceneFile grid = parse(sheet());
    SceneFile mesh = grid;
    mesh.scene.cloths[0].mesh = make_grid({.resolution = {3, 3}});
    SceneFile moved = mesh;
    moved.scene.cloths[0].mesh->positions(4, 1) += 1e-17;
    CHECK(difference(grid, mesh) == "cloth[0].size");  // a mesh takes its place
    CHECK(difference(mesh, moved) == "cloth[0].mesh");
    CHECK(difference(mesh, mesh) == "");
    SceneFile printed = grid;
    printed.looks.cloths[0].texture = std::make_shared<render::Image>(render::Image{1, 1, {1, 2, 3, 255}});
    CHECK(difference(grid, printed) == "cloth[0].texture");
    SceneFile two = grid;
    two.scene.pins.resize(1);
    CHECK(difference(grid, two) == "camera");
    CHECK(difference(two, grid) == "pin[0]");
}

// ---------------------------------------------------------------- resolved scenes

TEST_CASE("a resolved scene loads to the same scene, bit for bit", "[scene_file]") {
    const auto check_round_trip = [](const SceneFile& file) {
        INFO(file.resolved());
        // Read elsewhere: meshes have to be named absolutely.
        const TemporaryFolder elsewhere;
        const SceneFile again = parse_scene(file.resolved(), file.name + ".toml", elsewhere.path());
        CHECK(difference(again, file) == "");
        CHECK(again.resolved() == file.resolved());
        CHECK(again.view == file.view);
        CHECK(again.ground == file.ground);
    };
    SECTION("with no key given") {
        check_round_trip(parse(sheet()));
    }
    SECTION("with numbers that are hard to write") {
        check_round_trip(
            parse(sheet(),
                  {"cloth.translate=[-0.0, 5e-324, 1.7976931348623157]", "simulation.frame_rate=0.1",
                   "cloth.bump=1e-22", "cloth.scale=0.30000000000000004", "cloth.name=a \"b\" \\ c\x7f\x01",
                   "cloth.color=[0, 1, 0.123456789]", "light.softness=0.1", "camera.up=[0.1, 0.7, 0.3]"}));
    }
    SECTION("the scenes of the project") {
        CHECK(list_scenes().size() >= 20);
        for (const auto& [name, description] : list_scenes()) {
            INFO(name);
            check_round_trip(load_scene(name));
        }
    }
}

TEST_CASE("single-precision numbers are written as typed", "[scene_file]") {
    const std::string text =
        parse(sheet("[[light]]\ndirection = [0.45, 1.0, -0.1]\nintensity = 2.7\n")).resolved();
    CHECK_THAT(text, Contains("\ndirection = [0.45, 1.0, -0.1]\n") && Contains("\nintensity = 2.7\n"));
    CHECK_THAT(parse(sheet()).resolved(),
               Contains("\nintensity = 2.6\n") && Contains("\nsoftness = 0.003\n"));
}

TEST_CASE("a scene can be written with its files under other names", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "rest.ply", ply_bytes(make_grid({.resolution = {3, 3}})));
    const SceneFile f =
        parse_scene(sheet("mesh = \"rest.ply\"\npose = \"rest.ply\"\n"), "s.toml", folder.path());
    const std::string text = f.resolved({{"cloth[0].mesh", "meshes/a.obj"}});
    CHECK_THAT(text, Contains("\nmesh = \"meshes/a.obj\"\n"));
    CHECK_THAT(text, Contains("\npose = \"" + (folder / "rest.ply").string() + "\"\n"));
}

// ---------------------------------------------------------------- what is told of keys

TEST_CASE("the key reference has each key's kind, unit, range, default and meaning", "[scene_file]") {
    const std::string text = key_reference();
    for (
        const char* line :
        {"  frame_rate         number, 0.001 … 1000000 [1/s]\n                                               "
         " "
         "frame k stands at time k / frame_rate; default 60.0\n",
         "  gravity            [x, y, z], ±10000 [m/s²]   acceleration; default [0.0, -9.81, 0.0]\n",
         "  field_of_view      number, 1 … 160 [degree]   vertical; default 35.0\n",
         "  quality            whole number, 0 … 51       H.264 constant rate factor; 0: lossless; default "
         "18\n",
         "  frames             whole number, 1 … 999999   when the command line does not say; default 300\n",
         "  density            number, 1e-6 … 1000000 [kg/m²]\n                                              "
         "  mass per area; default 0.15\n",
         "  poisson_ratio      number, -1 < … < 1         in-plane",
         "  strain_limit       number, > 1, ≤ 1000 or 0   stretch that no triangle reaches; 0: none; default "
         "0.0\n",
         "  friction           number, 0 … 1000           Coulomb coefficient",
         "  wireframe          true or false              the edges of the simulated triangles; default "
         "false\n",
         "  edge               one of left, right, bottom, top\n",
         "  time_step          number, 1e-9 … 1000 [s]    longest step; a frame is cut into the fewest equal "
         "ones; none by default\n"}) {
        CHECK_THAT(text, Contains(line));
    }
    std::istringstream lines(text);
    int count = 0;
    for (std::string line; std::getline(lines, line);) {
        CHECK((line.empty() || line.back() != ' '));
        if (line.size() < 4 || line.compare(0, 2, "  ") != 0 || line[2] == ' ') continue;
        ++count;
        INFO(line);
        REQUIRE(line.size() > 21);
        CHECK(line[21] != ' ');
    }
    CHECK(count > 100);
}

namespace {

/// Calls f(schema) for the schema of each number that one of a key's has inside.
void for_each_number_schema(const Json& schema, const std::function<void(const Json&)>& f) {
    const Json type = schema.value("type", Json());
    if (type == "number" || type == "integer") f(schema);
    if (schema.contains("items")) for_each_number_schema(schema["items"], f);
    for (const char* parts : {"anyOf", "properties"}) {
        if (!schema.contains(parts)) continue;
        for (const auto& [name, part] : schema[parts].items()) for_each_number_schema(part, f);
    }
}

/// The same value with `number` in place of each of its numbers.
std::string with_numbers(const std::string& value, const std::string& number) {
    return std::regex_replace(value, std::regex("-?[0-9][0-9.e+-]*"), number);
}

}  // namespace

TEST_CASE("no key takes a number beyond reason", "[scene_file]") {
    const std::map<std::string, Setting> special = settings("/nowhere");
    SceneFile each = scene_of_each();
    int keys = 0;
    for (const Table& table : tables_of(each, each.files)) {
        for (const Field& field : table.fields) {
            const std::string name = table.name + (table.name.empty() ? "" : ".") + field.key;
            CAPTURE(name);
            if (field.words == "name or index") continue;  // as many as there are
            const Json schema = Json::parse(field.schema);
            int numbers = 0;
            for_each_number_schema(schema, [&](const Json& number) {
                CAPTURE(number.dump());
                ++numbers;
                CHECK((number.contains("minimum") || number.contains("exclusiveMinimum")));
                CHECK((number.contains("maximum") || number.contains("exclusiveMaximum")));
            });
            if (numbers == 0 || field.key == "version") continue;
            ++keys;
            const auto found = special.find(name);
            const Setting setting = found == special.end() ? Setting{} : found->second;
            const std::string value =
                setting.value.empty() ? value_of(schema, 1, field.write()) : setting.value;
            for (const char* number : {"1e300", "-1e300"}) {
                Overrides overrides = setting.needs;
                overrides.push_back(name + "=" + with_numbers(value, number));
                CAPTURE(overrides.back().setting);
                // Of whole numbers none is so large; else the key's own range is told.
                CHECK_THAT(refusal(setting.scene.empty() ? all_tables : setting.scene, overrides),
                           Contains(field.key) && (Contains("; must ") || Contains("is out of range")));
            }
        }
    }
    CHECK(keys > 90);
}

TEST_CASE("the JSON Schema takes the project's scenes and refuses what the reader refuses", "[scene_file]") {
    const Json schema = Json::parse(json_schema());
    CHECK(schema["$schema"] == "https://json-schema.org/draft/2020-12/schema");
    const Json& density =
        schema["properties"]["cloth"]["items"]["properties"]["fabric"]["anyOf"][1]["properties"]["density"];
    CHECK(density ==
          Json::parse(
              R"({"type":"number","minimum":1e-6,"maximum":1000000,"description":"mass per area [kg/m²]",
                                     "unit":"kg/m²","default":0.15})"));
    for (const auto& [name, description] : list_scenes()) {
        INFO(name);
        CHECK(testing::fault(schema, load_scene(name).resolved()) == "");
    }
    CHECK(testing::fault(schema, sheet("resolution = [4, 3]\nfabric = \"cotton\"\n[light]\n")) == "");
    for (const auto& [text, place] : std::vector<std::array<std::string, 2>>{
             {"[[cloth]]\n", "/version"},
             {"version = 1\n", "/cloth"},
             {"version = 1\ncloth = []\n", "/cloth"},
             {"version = 2\n[[cloth]]\n", "/version"},
             {sheet("sise = [1, 1]\n"), "/cloth/0/sise"},
             {sheet("size = [1]\n"), "/cloth/0/size"},
             {sheet("size = [1, 0]\n"), "/cloth/0/size/1"},
             {sheet("bump = true\n"), "/cloth/0/bump"},
             {sheet("diagonals = \"zigzag\"\n"), "/cloth/0/diagonals"},
             {sheet("resolution = 1\n"), "/cloth/0/resolution"},
             {sheet("color = \"red\"\n"), "/cloth/0/color"},
             {sheet("fabric = \"coton\"\n"), "/cloth/0/fabric"},
             {sheet("fabric = { strain_limit = 0.5 }\n"), "/cloth/0/fabric"},
             {sheet("[simulation]\nretries = 0.5\n"), "/simulation/retries"},
             {sheet("[output]\nframes = 1000000\n"), "/output/frames"},
             {sheet("[[pin]]\npath = [{ translate = [0, 0, 0] }]\n"), "/pin/0/path/0/time"},
             {sheet("[[seam]]\nfirst = { edge = \"left\" }\n"), "/seam/0/second"},
             {sheet("[[light]]\n[[light]]\n"), "/light"},
         }) {
        INFO(text);
        CHECK(testing::fault(schema, text) == place);
        CHECK(refusal(text) != "");
    }
}
