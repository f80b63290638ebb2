// What stands in the tables, the plot and the page; how the movie of all cells is laid out.

#include <catch2/catch.hpp>
#include <cmath>

#include "pipeline/formats/npy.h"
#include "pipeline/sweep/index_page.h"
#include "pipeline/sweep/measures.h"
#include "pipeline/sweep/results.h"
#include "pipeline/sweep/sheet_movie.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth::pipeline;
using Catch::Contains;

namespace {

/// Two cells of one that is done and one that failed, and one that is missing.
struct Kept {
    TemporaryFolder folder;
    SweepFile sweep;
    SweepResults results;

    Kept() {
        sweep.name = "weights";
        sweep.description = "a, \"b\" </script>";
        sweep.results.measures = {"drape_coefficient", "lowest_point"};
        SweepCells cells;
        cells.keys = {"cloth.fabric", "x"};
        const std::pair<const char*, double> made_of[] = {{"silk", 0.1}, {"silk", 40.0}, {"wool", 2.0}};
        for (const auto& [fabric, x] : made_of) {
            Cell cell;
            cell.name = fabric + std::string("_") + std::to_string(cells.cells.size());
            cell.key = "k" + cell.name;
            cell.values = {{"cloth.fabric", '"' + std::string(fabric) + '"', NAN, {}},
                           {"x", std::to_string(x), x, {}}};
            cells.cells.push_back(cell);
        }
        CellRecords records;
        CellRecord& done = records["silk_0"];
        done.key = "ksilk_0";
        done.frames = 60;
        done.last_frame = 59;
        for (std::size_t m = 0; m < measures().size(); ++m)
            done.measures.push_back(1.0 / 3 + static_cast<double>(m));
        CellRecord& failed = records["silk_1"];
        failed.key = "ksilk_1";
        failed.status = CellStatus::failed;
        failed.reason = "frame 3: did not converge, \"so\"";
        records["wool_2"].key = "of another scene";
        results = results_of(sweep, std::move(cells), records);
    }
};

}  // namespace

TEST_CASE("the table has every cell, its status and numbers to the last bit", "[sweep]") {
    const Kept kept;
    CHECK(results_csv(kept.results) ==
          "cell,status,sample,cloth.fabric,x,drape_coefficient,lowest_point,frames,last_frame,reason\r\n"
          "silk_0,done,,silk,0.100000,0.3333333333333333,2.3333333333333335,60,59,\r\n"
          "silk_1,failed,,silk,40.000000,nan,nan,0,-1,\"frame 3: did not converge, \"\"so\"\"\"\r\n"
          "wool_2,missing,,wool,2.000000,nan,nan,,,\r\n");
    const auto npz = kept.folder / "results.npz";
    write_results_npz(kept.results, npz);
    const NpzReader reader(npz);
    CHECK(reader.read("x").numbers == std::vector<double>{0.1, 40, 2});
    const NumberArray drape = reader.read("drape_coefficient");
    CHECK(drape.shape == std::vector<std::int64_t>{3});
    CHECK(drape.numbers[0] == 1.0 / 3);
    CHECK(std::isnan(drape.numbers[1]));
    for (const char* name : {"cells", "status", "sample", "cloth.fabric", "columns", "units"})
        CHECK(reader.has(name));
}

TEST_CASE("a plot has a series a word, and logarithmic axes where numbers span decades", "[sweep]") {
    const Kept kept;
    const cloth::Plot plot = plot_of(kept.results, "x", "drape_coefficient");
    CHECK(plot.log_x);
    CHECK_FALSE(plot.log_y);
    CHECK(plot.y_label == "drape coefficient [%]");
    REQUIRE(plot.curves.size() == 1);  // the others have no numbers
    CHECK(plot.curves[0].label == "silk");
    CHECK(plot.curves[0].points.size() == 1);
    CHECK_THAT(message_of([&] { plot_of(kept.results, "x", "drape"); }, ExitCode::usage),
               Contains("--plot: the results have no drape; ") && Contains("lowest_point"));
    CHECK_THAT(message_of([&] { plot_of(kept.results, "cloth.fabric", "x"); }, ExitCode::usage),
               Contains("cloth.fabric is no number in every cell"));
}

TEST_CASE("no text of a sweep ends its page's script", "[sweep]") {
    const Kept kept;
    const SweepFolder folder = SweepFolder::create(kept.folder / "out", kept.sweep);
    const std::string page = index_page(kept.results, folder);
    CHECK_THAT(page, Contains("a, &quot;b&quot; &lt;/script&gt;"));
    CHECK_THAT(page, Contains("\"reason\":\"frame 3: did not converge, \\\"so\\\"\""));
    for (const char* place : {"@mark@", "@title@", "@scene@", "@movie@", "@style@", "@script@", "@data@"})
        CHECK(page.find(place) == std::string::npos);
    CHECK(page.find("<video") == std::string::npos);
}

TEST_CASE("pictures of a movie of all cells are as large as its page lets them be", "[sweep]") {
    const SheetGrid one = sheet_grid(1, 16.0 / 9, 320);
    CHECK((one.columns == 1 && one.rows == 1 && one.width == 320 && one.height == 180));
    const SheetGrid twelve = sheet_grid(12, 16.0 / 9, 320);
    CHECK((twelve.width == 320 && twelve.columns * twelve.rows >= 12 && twelve.columns <= 4));
    const SheetGrid thousand = sheet_grid(1000, 16.0 / 9, 320);
    CHECK(thousand.width >= 110);
    CHECK(thousand.columns * thousand.width <= 3840);
    CHECK(thousand.rows * thousand.height <= 2160);
    CHECK(thousand.columns * thousand.rows >= 1000);
}
