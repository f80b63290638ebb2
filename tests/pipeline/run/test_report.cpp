// report.json and the ledger: what is written is read again.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "pipeline/run/ledger.h"
#include "pipeline/run/report.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

SceneFile small_scene() {
    return parse_scene("version = 1\n[[cloth]]\nresolution = [3, 4]\nfabric = \"cotton\"\n[[collider]]\n",
                       "scene.toml", ".",
                       {"simulation.contact=barrier", "simulation.integrator=implicit_euler"});
}

RunSummary two_frames() {
    RunSummary summary;
    summary.scene = "scene";
    summary.frames = 2;
    summary.records.resize(2);
    FrameReport& report = summary.records[1].report;
    report.frame = 1;
    report.steps = 4;
    report.iterations = 31;
    report.residual = 0.1 + 0.2;  // needs all of its digits
    report.retries = 2;
    report.energy_before = -1.0 / 3.0;
    report.energy_after = 1e-300;
    report.largest_stretch = 1.0625;
    report.smallest_gap = 1e-4;
    report.contacts = 12;
    report.placements = 3;
    report.cg_iterations = 500;
    report.factorizations = 33;
    report.contact_times.assembly = 0.5;
    summary.records[1].state_hash = "00ff";
    summary.records[1].host = "loom";
    summary.records[1].simulate = 0.25;
    return summary;
}

}  // namespace

TEST_CASE("every counter of a frame is read from the ledger as it was written", "[report]") {
    const TemporaryFolder place;
    const RunFolder folder = RunFolder::create(place.path());
    const RunSummary summary = two_frames();
    Ledger ledger(folder.ledger(), {});
    for (const FrameRecord& record : summary.records)
        ledger.add_state(record.report.frame, {"key", "file", record});
    const FrameReports reports = read_frame_reports(folder);
    REQUIRE(reports.size() == 2);
    for (const FrameRecord& record : summary.records) {
        const FrameReport &written = record.report, &read = reports.at(written.frame);
        CHECK(read.steps == written.steps);
        StepReport::describe([&](const char* name, auto member, const char*, auto) {
            CAPTURE(name);
            CHECK(read.*member == written.*member);
        });
    }
    const FrameRecord kept = read_ledger(folder.ledger()).states.at(1).record;
    CHECK(kept.state_hash == "00ff");
    CHECK(kept.host == "loom");
    CHECK(kept.simulate == 0.25);
}

TEST_CASE("a ledger's last word about a file counts, and a line that is cut or makes no sense says nothing",
          "[report]") {
    const TemporaryFolder place;
    const RunFolder folder = RunFolder::create(place.path());
    CHECK(read_ledger(folder.ledger()).states.empty());
    {
        Ledger ledger(folder.ledger(), {});
        ledger.add_picture(3, {"old", "a", "r"});
        ledger.add_picture(3, {"new", "b", "r"});
        ledger.add_movie("scene.mp4", {"key", "file", "ffmpeg"});
    }
    const std::string good = slurp(folder.ledger());
    const std::string state = R"({"state":1,"key":"k","file":"f","report":{"frame":2}})";
    for (const std::string& more :
         {std::string("{\"picture\": 4, \"key\""), std::string("[]\n"), std::string("7\n{}\n"),
          std::string("{\"picture\":-1,\"key\":\"\",\"file\":\"\",\"renderer\":\"\",\"seconds\":[0,0]}\n"),
          state + "\n"}) {
        CAPTURE(more);
        spit(folder.ledger(), good + more);
        const LedgerEntries entries = read_ledger(folder.ledger());
        CHECK(entries.states.empty());
        REQUIRE(entries.pictures.size() == 1);
        CHECK(entries.pictures.at(3).key == "new");
        CHECK(entries.movies.at("scene.mp4").encoder == "ffmpeg");
    }
}

TEST_CASE("a report names counters with their units, and tells of gaps only where something is near",
          "[report]") {
    const TemporaryFolder place;
    const RunFolder folder = RunFolder::create(place.path());
    const SceneFile file = small_scene();
    write_report(folder, file, build_model(file.scene), two_frames(), "complete");
    const auto json = nlohmann::json::parse(slurp(folder.report()));
    CHECK(json["outcome"] == "complete");
    CHECK(json["simulation"]["vertices"] == 12);
    CHECK(json["contact_times_s"]["assembly"] == 0.5);
    CHECK(json["contact_times_s"]["conjugate_gradients"] == 0.0);
    const auto& frame = json["frames"][1];
    CHECK(frame["energy_after_J"] == 1e-300);
    CHECK(frame["smallest_gap_m"] == 1e-4);
    CHECK(frame["largest_penetration_m"] == 0.0);
    CHECK(frame["cg_iterations"] == 500);
    CHECK(frame["state_hash"] == "00ff");
    CHECK(json["frames"][0]["smallest_gap_m"].is_null());
    CHECK(json["frames"][0]["largest_penetration_m"].is_null());
}

TEST_CASE("redrawing adds to the report and leaves the rest of it", "[report]") {
    const TemporaryFolder place;
    const RunFolder folder = RunFolder::create(place.path());
    const SceneFile file = small_scene();
    write_report(folder, file, build_model(file.scene), two_frames(), "complete");
    RunSummary redrawn;
    redrawn.images = 7;
    amend_report(folder, redrawn);
    const auto json = nlohmann::json::parse(slurp(folder.report()));
    CHECK(json["redrawn"]["images"] == 7);
    CHECK(json["outcome"] == "complete");
    CHECK(json["frames"].size() == 2);
}

TEST_CASE("a report that is missing or no report is begun anew", "[report]") {
    const TemporaryFolder place;
    const RunFolder folder = RunFolder::create(place.path());
    for (const char* text : {"", "{", "[]", "7", R"({"frames": 3})"}) {
        CAPTURE(text);
        spit(folder.report(), text);
        amend_report(folder, {});
        CHECK(nlohmann::json::parse(slurp(folder.report())).contains("redrawn"));
    }
}
