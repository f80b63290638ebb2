#include "pipeline/golden/golden_verdict.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"

namespace cloth::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: a difference without a bound is null.
Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json();
}

std::string test_case(const std::string& scene, const std::string& name, const std::string& reason) {
    const std::string head =
        fmt::format("    <testcase classname=\"golden.{}\" name=\"{}\"", escaped(scene), escaped(name));
    if (reason.empty()) return head + "/>\n";
    return fmt::format("{}>\n      <failure message=\"{}\"/>\n    </testcase>\n", head, escaped(reason));
}

}  // namespace

Json golden_json(const GoldenResult& result) {
    Json rows = Json::array();
    for (const GoldenRow& row : result.rows) {
        const render::ImageDifference& d = row.image.difference;
        rows.push_back({{"frame", row.frame},
                        {"state",
                         {{"passed", row.state.passed},
                          {"largest_distance_m", number(row.state.largest_distance)},
                          {"worst_vertex", row.state.worst_vertex},
                          {"reason", row.state.reason}}},
                        {"picture",
                         {{"passed", row.image.passed},
                          {"largest_difference", d.largest},
                          {"fraction_over_2", number(d.fraction_over_2)},
                          {"fraction_over_32", number(d.fraction_over_32)},
                          {"psnr_dB", number(d.psnr)},
                          {"reason", row.image.reason}}}});
    }
    return {{"scene", result.scene},
            {"passed", result.passed},
            {"state_tolerance_m", result.state_tolerance},
            {"build", {{"golden", result.golden_build}, {"actual", result.actual_build}}},
            {"renderer", {{"golden", result.golden_renderer}, {"actual", result.actual_renderer}}},
            {"frames", std::move(rows)},
            {"report", result.report.string()}};
}

std::string golden_junit(const GoldenResult& result) {
    std::string cases;
    std::size_t failures = 0;
    for (const GoldenRow& row : result.rows) {
        cases += test_case(result.scene, fmt::format("frame {}, state", row.frame), row.state.reason);
        cases += test_case(result.scene, fmt::format("frame {}, picture", row.frame), row.image.reason);
        failures += (row.state.passed ? 0U : 1U) + (row.image.passed ? 0U : 1U);
    }
    const std::string counts = fmt::format("tests=\"{}\" failures=\"{}\"", 2 * result.rows.size(), failures);
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {0}>\n"
        "  <testsuite name=\"golden.{1}\" {0}>\n{2}  </testsuite>\n</testsuites>\n",
        counts, escaped(result.scene), cases);
}

}  // namespace cloth::pipeline
