// The program as other programs drive it: results, lists and progress as JSON, verdicts as JUnit's XML.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/workplace.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

/// Each line of a text as an object.
std::vector<json> lines_of(const std::string& text) {
    std::vector<json> all;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) all.push_back(json::parse(line));
    return all;
}

}  // namespace

TEST_CASE("progress as JSON: one object a line, the result the last", "[cli][driven]") {
    const Workplace place;
    const Outcome run = place.run("--scene sheet.toml --out o --frames 5 --progress=json");
    REQUIRE(run.code == 0);
    CHECK(run.err.empty());
    const std::vector<json> lines = lines_of(run.out);
    REQUIRE(lines.size() >= 2);
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        CHECK(lines[i]["event"] == "progress");
        CHECK(lines[i]["frames"] == 5);
        CHECK(lines[i]["simulated"] <= 5);
        CHECK(lines[i]["seconds"].is_number());
    }
    CHECK(lines.back()["event"] == "result");
    CHECK(lines.back()["states"] == json({{"made", 5}, {"kept", 0}}));
    CHECK(lines.back()["movie"] == "o/sheet.mp4");
    CHECK(lines.back()["times_s"]["simulate"].get<double>() > 0.0);

    // What would be lost is told as an object too.
    const Outcome again = place.run("--scene sheet.toml --out o --frames 5 --progress=json --fresh");
    REQUIRE(again.code == 0);
    CHECK(again.err.empty());
    CHECK(lines_of(again.out).front()["event"] == "note");
    CHECK_THAT(lines_of(again.out).front()["text"].get<std::string>(), Contains("--fresh: 5 states"));
    // A failure is told on standard error, by a line and the exit code, as always.
    check_refusal(place.run("--scene none.toml --progress=json"), 3, {"none.toml"});
    check_refusal(place.run("--scene sheet.toml --progress=xml"), 2, {"--progress", "xml"});
}

TEST_CASE("the result of a run, a plan, an audit and gc as JSON", "[cli][driven]") {
    const Workplace place;
    const Outcome run = place.run(base + "--frames 3 --no-video --json");
    REQUIRE(run.code == 0);
    const json result = json::parse(run.out);
    CHECK(result["scene"] == "sheet");
    CHECK(result["out"] == "o");
    CHECK(result["pictures"]["made"] == 3);
    CHECK(result["movie"] == "");
    const json plan = json::parse(place.run(base + "--frames 4 --no-video --explain --json").out);
    CHECK(plan["event"] == "plan");
    CHECK_THAT(plan["parts"][0].get<std::string>(), Contains("states: 3 kept"));

    const json good = json::parse(place.run("audit o --json").out);
    CHECK(good["good"] == true);
    CHECK(good["states_read"] == 3);
    CHECK(good["findings"].empty());
    spit(place / "o/states/state_000002.bin", "no state");
    const Outcome bad = place.run("audit o --json");
    CHECK(bad.code == 8);
    CHECK(json::parse(bad.out)["good"] == false);
    CHECK(json::parse(bad.out)["findings"][0]["frame"] == 2);

    const json garbage = json::parse(place.run("gc o --json").out);
    CHECK(garbage["removed"] == false);
    REQUIRE(garbage["files"].size() >= 1);
    CHECK_THAT(garbage["files"][0]["file"].get<std::string>(), Contains("state_000002.bin"));
    CHECK(json::parse(place.run("gc o --json --yes").out)["removed"] == true);
    CHECK(json::parse(place.run("gc o --json").out)["files"].empty());
}

TEST_CASE("lists as JSON", "[cli][driven]") {
    const Workplace place;
    const json scenes = json::parse(place.run("list --json").out);
    CHECK(
        std::any_of(scenes.begin(), scenes.end(), [](const json& s) { return s["name"] == "drape_sphere"; }));
    const json fabrics = json::parse(place.run("list fabrics --json").out);
    CHECK(fabrics.size() > 3);
    const json cotton = json::parse(place.run("list fabrics cotton --json").out);
    REQUIRE(cotton.size() == 1);
    CHECK(cotton[0]["name"] == "cotton");
    CHECK(cotton[0]["values"][0]["source"].get<std::string>() != "");
    check_refusal(place.run("list fabrics felt --json"), 2, {"there is no fabric \"felt\""});
    const json formats = json::parse(place.run("list formats --json").out);
    CHECK(std::any_of(formats.begin(), formats.end(),
                      [](const json& f) { return f["name"] == "gltf" && f["extensions"][0] == ".glb"; }));
    check_refusal(place.run("list keys --json"), 2, {"takes no --json", "list schema"});
    const json findings =
        json::parse(place.run("validate cantilever --gamma 1 --resolution 8 --json --plots p").out.c_str(),
                    nullptr, false);
    REQUIRE(findings.is_array());
    CHECK(findings[0]["check"] == "cantilever");
    check_refusal(place.run("validate --json --markdown"), 2, {"--json, --markdown: give one of the two"});
}

TEST_CASE("a comparison with goldens as JSON and as JUnit's XML", "[cli][driven]") {
    const Workplace place;
    REQUIRE(place.run("bless sheet.toml --golden g --out o").code == 0);
    const Outcome same = place.run("compare sheet.toml --golden g --out o --json --junit same.xml");
    REQUIRE(same.code == 0);
    CHECK(json::parse(same.out)["passed"] == true);
    CHECK_THAT(slurp(place / "same.xml"),
               Contains("<testsuites tests=\"") && Contains("failures=\"0\"") &&
                   Contains("classname=\"golden.sheet\" name=\"frame 0, state\"/>"));
    const Outcome other = place.run(
        "compare sheet.toml --golden g --out o --json --junit other.xml --set simulation.gravity=[0,-9.8,0]");
    CHECK(other.code == 6);
    const json verdict = json::parse(other.out);
    CHECK(verdict["passed"] == false);
    CHECK(verdict["frames"].back()["state"]["passed"] == false);
    CHECK(verdict["frames"].back()["state"]["largest_distance_m"].get<double>() > 0.0);
    CHECK_THAT(slurp(place / "other.xml"), Contains("<failure message=\"vertex "));
}
