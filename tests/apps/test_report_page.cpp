// The page that a run leaves, and that of two runs: when it is made, what it holds, what is refused.

#include <sys/stat.h>

#include <catch2/catch.hpp>
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
    const nlohmann::json data = data_of(slurp(place / "two.html"));
    CHECK(data["runs"].size() == 2);
    CHECK_THAT(data["lines"][1].get<std::string>(), Contains("simulation.gravity"));
    CHECK(data["runs"][0]["frames"]["apart_m"][0] == 0.0);
    CHECK(data["runs"][0]["frames"]["apart_m"][3].get<double>() ==
          Approx(verdict["largest_distance_m"].get<double>()));
    CHECK(data["runs"][0]["movie"].contains("text"));

    REQUIRE(
        place.run("--scene sheet.toml --out q --quiet --frames 2 --no-video --set cloth.resolution=5").code ==
        0);
    CHECK_THAT(place.run("report o q").out, Contains("their numbers of vertices differ"));
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
    for (const char* state : {"o/states/state_000000.bin", "o/states/state_000001.bin"})
        fs::remove(place / state);
    check_refusal(place.run("report o"), 1, {"keeps no states"});
}
