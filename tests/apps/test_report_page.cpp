// The page that a run leaves, and that of two runs: when it is made, what it holds, what is refused.

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/workplace.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// What a page shows.
nlohmann::json data_of(const std::string& page) {
    const std::string begin = "<script type=\"application/json\" id=\"data\">";
    const std::size_t from = page.find(begin) + begin.size();
    return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

}  // namespace

TEST_CASE("a run leaves a page that holds its movie, measures, frames and scene", "[cli][page]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 5").code == 0);
    const std::string page = slurp(place / "o/report.html");
    for (const char* outside : {"src=\"http", "href=\"http", "@import", "@MARK@", "@DATA@"})
        CHECK_THAT(page, !Contains(outside));
    const nlohmann::json data = data_of(page);
    CHECK(data["title"] == "sheet");
    CHECK(data["verdict"]["text"] == "complete");
    const nlohmann::json& run = data["runs"][0];
    CHECK(run["frames"]["frame"] == nlohmann::json({0, 1, 2, 3, 4}));
    CHECK(run["frames"]["iterations"][0].is_null());
    CHECK(run["frames"]["iterations"][4].get<int>() > 0);
    CHECK(run["movie"]["data"].get<std::string>().size() > 100);
    CHECK(run["view"]["frames"].size() == 5);
    CHECK(run["view"]["vertices"] == 144);
    std::vector<std::string> fields;
    for (const auto& field : run["view"]["fields"]) fields.push_back(field["name"]);
    CHECK(fields == std::vector<std::string>{"stretch", "bending", "kinetic", "gap", "strain_rate"});
    CHECK(run["view"]["cameras"] == nlohmann::json({{0.4, 1.0, 2.6, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 35.0}}));
    CHECK(run["view"]["colliders"][0]["poses"].size() == 1);  // it stands still
    CHECK(run["frames"]["draw"][4].get<double>() > 0);
    CHECK_THAT(run["scene"].get<std::string>(), Contains("[[cloth]]"));

    // It is made again where what it shows has changed, and only there.
    const auto written = [&] { return fs::last_write_time(place / "o/report.html"); };
    const auto first = written();
    REQUIRE(place.run(base + "--frames 5").code == 0);
    CHECK(written() == first);
    REQUIRE(place.run(base + "--frames 6").code == 0);
    CHECK(written() != first);
    CHECK(data_of(slurp(place / "o/report.html"))["runs"][0]["frames"]["frame"].size() == 6);
    const Outcome again = place.run("report o");
    CHECK(again.code == 0);
    CHECK(again.out == "o/report.html\n");
    CHECK(place.run("gc o").out == "nothing that no run needs in 1 run\n");
}

TEST_CASE("the view of a page is coloured as the scene's pictures are", "[cli][page]") {
    const Workplace place;
    REQUIRE(place
                .run(base +
                     "--frames 2 --no-video --shade strain_rate --shade-range 0:3 --set camera.turntable=90")
                .code == 0);
    const nlohmann::json view = data_of(slurp(place / "o/report.html"))["runs"][0]["view"];
    CHECK(view["shade"] == "strain_rate");
    CHECK(view["fields"][4]["low"] == 0.0);
    CHECK(view["fields"][4]["high"] == 3.0);
    CHECK(view["cameras"].size() == 2);  // it moves
}

TEST_CASE("a page says what is broken, and does not outlive what it shows", "[cli][page]") {
    const Workplace place;
    CHECK(place.run(base + "--frames 3 --no-video --set expect.max_seconds_per_frame=0").code == 8);
    nlohmann::json data = data_of(slurp(place / "o/report.html"));
    CHECK(data["verdict"]["text"] == "a limit is broken");
    CHECK(data["runs"][0]["expect"][0]["holds"] == false);
    {
        Started longer(place, base + "--frames 100000 --no-video");
        REQUIRE(comes_true([&] { return fs::exists(place / "o/states/state_000005.bin"); }));
        CHECK_FALSE(fs::exists(place / "o/report.html"));
    }
    // What overlaps at the start is in the page.
    CHECK(place
              .run("--scene sheet.toml --out p --quiet --frames 3 --set simulation.contact=barrier --set "
                   "simulation.integrator=implicit_euler --set cloth.translate=[0,0,0]")
              .code == 5);
    data = data_of(slurp(place / "p/report.html"));
    CHECK_THAT(data["picture"]["url"].get<std::string>(), Catch::StartsWith("data:image/png;base64,"));
    REQUIRE(data["faults"].size() == 1);
    CHECK_THAT(data["faults"][0].get<std::string>(), Contains("overlap"));
}

TEST_CASE("the page of two runs tells where they part", "[cli][page]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 4 --no-video").code == 0);
    REQUIRE(place
                .run("--scene sheet.toml --out p --quiet --frames 6 --no-video --set "
                     "simulation.gravity=[0,-9.7,0]")
                .code == 0);
    const Outcome same = place.run("report o o");
    CHECK(same.code == 0);
    CHECK(same.out == "o and o: the same in 4 frames: report.html\n");
    CHECK(data_of(slurp(place / "report.html"))["verdict"]["text"] == "the same");
    const Outcome other = place.run("report o p --file two.html --json");
    CHECK(other.code == 0);
    const nlohmann::json verdict = nlohmann::json::parse(other.out);
    CHECK(verdict["same"] == false);
    CHECK(verdict["common_frames"] == 4);
    CHECK(verdict["first_different_frame"] == 1);
    CHECK(verdict["largest_distance_frame"] == 3);
    CHECK(verdict["distance_there_m"].get<double>() > 0);
    CHECK(verdict["rms_distance_there_m"].get<double>() < verdict["largest_distance_m"].get<double>());
    CHECK_THAT(verdict["largest_distance_of"].get<std::string>(), Contains("of cloth"));
    const nlohmann::json data = data_of(slurp(place / "two.html"));
    CHECK(data["runs"].size() == 2);
    CHECK(data["verdict"]["text"] == "they part in frame 1");
    CHECK_THAT(data["lines"][2].get<std::string>(), Contains("simulation.gravity"));
    CHECK(data["runs"][0]["view"]["shade"] == "apart");
    CHECK(data["runs"][1]["view"]["fields"][0]["name"] == "apart");
    CHECK(data["runs"][0]["frames"]["apart_rms_m"][3].get<double>() ==
          Approx(verdict["rms_distance_there_m"].get<double>()));
    CHECK(data["runs"][0]["frames"]["apart_m"][0] == 0.0);
    CHECK(data["runs"][0]["frames"]["apart_m"][3].get<double>() ==
          Approx(verdict["largest_distance_m"].get<double>()));
    CHECK(data["runs"][0]["movie"].contains("text"));

    REQUIRE(
        place.run("--scene sheet.toml --out q --quiet --frames 2 --no-video --set cloth.resolution=5").code ==
        0);
    CHECK_THAT(place.run("report o q").out, Contains("no states to compare, 144 vertices against 25"));
    REQUIRE(place.run("--scene sheet.toml --out r --quiet --frames 2 --no-video --fps 30").code == 0);
    CHECK_THAT(place.run("report o r").out, Contains("60 frames per second against 30"));
}

TEST_CASE("the page of a run shows its goldens where they are asked for", "[cli][page]") {
    const Workplace place;
    REQUIRE(place.run("bless sheet.toml --golden g --out blessed").code == 0);
    REQUIRE(place.run(base + "--frames 5 --no-video").code == 0);
    const Outcome same = place.run("report o --golden g");
    CHECK(same.code == 0);
    CHECK_THAT(same.out, Contains("sheet: agrees (same build") && Contains("report: o/report.html"));
    nlohmann::json data = data_of(slurp(place / "o/report.html"));
    CHECK(data["runs"].size() == 1);
    REQUIRE(data["golden"]["rows"].size() == 2);
    CHECK(data["golden"]["rows"][1]["good"] == true);

    REQUIRE(place.run(base + "--frames 5 --no-video --set simulation.gravity=[0,-9.5,0]").code == 0);
    const Outcome other = place.run("report o --golden g");
    CHECK(other.code == 6);
    CHECK_THAT(other.err, Contains("o differs from its goldens, see o/report.html"));
    data = data_of(slurp(place / "o/report.html"));
    CHECK(data["golden"]["rows"][0]["good"] == true);
    for (const char* picture : {"before", "moved", "moved_difference"})
        CHECK_THAT(data["golden"]["rows"][1][picture].get<std::string>(),
                   Catch::StartsWith("data:image/png"));

    check_refusal(place.run("report o --golden none"), 6, {"none/sheet/golden.json is missing"});
    check_refusal(place.run("report o o --golden g"), 2, {"--golden: belongs to the page of one run"});
    REQUIRE(
        place.run("--scene sheet.toml --out p --quiet --frames 2 --no-video --set expect.frames=[3]").code ==
        0);
    check_refusal(place.run("report p --golden g"), 6, {"p: keeps none of the golden frames of sheet"});
}

TEST_CASE("no page is made of what is no run, of no states, or over what is the user's", "[cli][page]") {
    const Workplace place;
    check_refusal(place.run("report nothing"), 1, {"nothing", "no run"});
    fs::create_directories(place / "mine");
    spit(place / "mine/letter.txt", "dear");
    check_refusal(place.run("report mine"), 1, {"mine", "no run"});
    REQUIRE(place.run(base + "--frames 2 --no-video").code == 0);
    check_refusal(place.run("report o --file x.html"), 2, {"--file: belongs to two runs"});
    check_refusal(place.run("report o --json"), 2, {"--json: belongs to two runs"});
    spit(place / "letter.html", "dear");
    check_refusal(place.run("report o o --file letter.html"), 2, {"letter.html: is there and no page"});
    CHECK(slurp(place / "letter.html") == "dear");
    check_refusal(place.run("report o o --file no/such/folder.html"), 1, {"no/such/folder.html"});
    check_refusal(place.run("report o nothing"), 1, {"nothing", "no run"});
    if (std::system("unshare -rm true 2>/dev/null") == 0) {
        spit(place / "read_only.sh",
             "mount --bind o o && mount -o remount,bind,ro o || exit 1\nexec \"$@\"\n");
        check_refusal(place.run("report o --threads 1", "rm o/report.html; unshare -rm sh ./read_only.sh"), 1,
                      {"o/report.html", "Read-only file system"});
    } else {
        WARN("no read-only folder can be made here (unshare -rm)");
    }
    for (const char* state : {"o/states/state_000000.bin", "o/states/state_000001.bin"})
        fs::remove(place / state);
    check_refusal(place.run("report o"), 1, {"keeps no states"});
}
