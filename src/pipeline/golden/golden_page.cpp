#include "pipeline/golden/golden_page.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/page/page.h"
#include "pipeline/run/run_folder.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The picture, to be shown in a page.
std::string url_of(const render::Image& image) {
    const std::vector<std::uint8_t> png = render::encode_png(image);
    return picture_url({reinterpret_cast<const char*>(png.data()), png.size()});
}

const char* word(bool passed) {
    return passed ? "same" : "DIFFERS";
}

std::string distance_text(const StateVerdict& verdict) {
    return verdict.passed && verdict.largest_distance == 0 ? "0"
                                                           : fmt::format("{:.2e}", verdict.largest_distance);
}

std::string psnr_text(const ImageVerdict& verdict) {
    return std::isinf(verdict.difference.psnr) ? "equal" : fmt::format("{:.1f}", verdict.difference.psnr);
}

}  // namespace

std::string bless_command(const std::string& scene) {
    return "render_cloth bless " + scene;
}

std::string golden_table(const GoldenResult& result) {
    std::string table = fmt::format("{:>7}  {:>10}  {:<8} {:>8}  {:>8}  {:>9}  {}\n", "frame", "state [m]",
                                    "state", "over 2", "over 32", "PSNR [dB]", "picture");
    for (const GoldenRow& row : result.rows) {
        const render::ImageDifference& d = row.image.difference;
        table += fmt::format("{:>7}  {:>10}  {:<8} {:>6.3f} %  {:>6.3f} %  {:>9}  {}\n", row.frame,
                             distance_text(row.state), word(row.state.passed), 100 * d.fraction_over_2,
                             100 * d.fraction_over_32, psnr_text(row.image), word(row.image.passed));
    }
    for (const GoldenRow& row : result.rows) {
        if (!row.state.passed) table += fmt::format("frame {}, state: {}\n", row.frame, row.state.reason);
        if (!row.image.passed) table += fmt::format("frame {}, picture: {}\n", row.frame, row.image.reason);
    }
    const bool same_build = result.golden_build == result.actual_build;
    const bool same_renderer = result.golden_renderer == result.actual_renderer;
    table += fmt::format(
        "{}: {} ({}, {})\n", result.scene, result.passed ? "agrees" : "differs",
        same_build ? std::string("same build, states exact")
                   : fmt::format("another build, states within {:.1g} m", result.state_tolerance),
        same_renderer ? "same renderer, pictures exact" : "another renderer, pictures within tolerance");
    return table;
}

nlohmann::ordered_json row_json(const GoldenRow& row, const render::Image* golden,
                                const render::Image* actual, const render::Image* moved) {
    const render::ImageDifference& d = row.image.difference;
    nlohmann::ordered_json json = {
        {"frame", row.frame},
        {"good", row.state.passed && row.image.passed},
        {"picture_good", row.image.passed},
        {"state", fmt::format("{}, distance {} m. {}", word(row.state.passed), distance_text(row.state),
                              row.state.reason)},
        {"picture",
         fmt::format(
             "{}, PSNR {} dB, over 2: {:.3f} %, over 32: {:.3f} %, worst by {} of 255 at ({}, {}). {}",
             word(row.image.passed), psnr_text(row.image), 100 * d.fraction_over_2, 100 * d.fraction_over_32,
             d.largest, d.worst_x, d.worst_y, row.image.reason)}};
    if (golden != nullptr) json["before"] = url_of(*golden);
    if (actual != nullptr) json["after"] = url_of(*actual);
    if (golden != nullptr && actual != nullptr && d.same_size)
        json["difference"] = url_of(render::magnified_difference(*golden, *actual, 16));
    if (moved != nullptr) json["moved"] = url_of(*moved);
    return json;
}

std::filesystem::path write_page(const GoldenResult& result, const nlohmann::ordered_json& rows,
                                 const fs::path& out) {
    std::error_code failure;
    fs::create_directories(out, failure);
    if (failure)
        throw Error(ExitCode::other, "cannot write to the folder " + out.string() + ": " + failure.message());
    const fs::path path = out / "golden.html";
    nlohmann::ordered_json data;
    data["mark"] = own_mark;
    data["title"] = fmt::format("{}: golden frames {}", result.scene, result.passed ? "agree" : "differ");
    data["verdict"] = {{"text", result.passed ? "agree" : "differ"},
                       {"tone", result.passed ? "good" : "bad"}};
    data["facts_head"] = {"", "golden", "now"};
    const auto fact = [](const char* name, const std::string& golden, const std::string& now) {
        return nlohmann::ordered_json::array({name, nlohmann::ordered_json::array({golden, now})});
    };
    data["facts"] =
        nlohmann::ordered_json::array({fact("build", result.golden_build, result.actual_build),
                                       fact("renderer", result.golden_renderer, result.actual_renderer)});
    data["text"] = golden_table(result);
    data["golden"] = {{"rows", rows}, {"command", bless_command(result.scene)}};
    write_file(path, page_text(data));
    return path;
}

}  // namespace cloth::pipeline
