#include "pipeline/golden/golden_page.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/page/page.h"
#include "pipeline/run/run_folder.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// By which pictures of differences are brightened.
constexpr int difference_gain = 16;

/// Takes their pictures from the rows that find no room in `most` bytes, and gives the number of these.
std::size_t drop_pictures(nlohmann::ordered_json& rows, std::size_t most) {
    std::size_t bytes = 0, dropped = 0;
    const auto take = [&](nlohmann::ordered_json& row) {
        constexpr std::array keys{"before", "after", "difference", "moved", "moved_difference"};
        std::size_t own = 0;
        for (const char* key : keys)
            if (row.contains(key)) own += row[key].get_ref<const std::string&>().size();
        if (bytes + own <= most) {
            bytes += own;
            return;
        }
        for (const char* key : keys) row.erase(key);
        ++dropped;
    };
    for (const bool good : {false, true})  // what differs is what is looked for
        for (nlohmann::ordered_json& row : rows)
            if (row["good"] == good) take(row);
    return dropped;
}

/// The picture, to be shown in a page.
std::string url_of(const render::Image& image) {
    const std::vector<std::uint8_t> png = render::encode_png(image);
    return picture_url({reinterpret_cast<const char*>(png.data()), png.size()});
}

std::string title_of(const GoldenResult& result) {
    return fmt::format("{}: golden frames {}", result.scene, result.passed ? "agree" : "differ");
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
    nlohmann::ordered_json json = {{"frame", row.frame},
                                   {"good", row.state.passed && row.image.passed},
                                   {"state_good", row.state.passed},
                                   {"picture_good", row.image.passed},
                                   {"distance", distance_text(row.state)},
                                   {"psnr", psnr_text(row.image)},
                                   {"over_2", fmt::format("{:.3f} %", 100 * d.fraction_over_2)},
                                   {"over_32", fmt::format("{:.3f} %", 100 * d.fraction_over_32)},
                                   {"reasons", nlohmann::ordered_json::array()}};
    if (!row.state.passed) json["reasons"].push_back("State: " + row.state.reason);
    if (!row.image.passed) json["reasons"].push_back("Picture: " + row.image.reason);
    const auto difference = [&](const render::Image& now) {
        return url_of(render::magnified_difference(*golden, now, difference_gain));
    };
    json["gain"] = difference_gain;
    if (golden != nullptr) json["before"] = url_of(*golden);
    // Where nothing differs the golden says it all.
    if (actual != nullptr && !row.image.passed) {
        json["after"] = url_of(*actual);
        if (golden != nullptr && d.same_size) json["difference"] = difference(*actual);
    }
    if (moved != nullptr) {
        json["moved"] = url_of(*moved);
        if (golden != nullptr && golden->width == moved->width && golden->height == moved->height)
            json["moved_difference"] = difference(*moved);
    }
    return json;
}

nlohmann::ordered_json page_part(const GoldenResult& result, nlohmann::ordered_json rows, std::size_t most) {
    nlohmann::ordered_json part;
    const std::size_t dropped = drop_pictures(rows, most);
    part["title"] = title_of(result);
    part["text"] = dropped == 0 ? std::string()
                                : fmt::format("The pictures of {} find no room in this page.",
                                              plural(static_cast<std::int64_t>(dropped), "frame"));
    part["rows"] = std::move(rows);
    part["command"] = bless_command(result.scene);
    part["states"] = result.golden_build == result.actual_build
                         ? "every bit"
                         : fmt::format("less than {:.1g} m", result.state_tolerance);
    return part;
}

std::filesystem::path write_page(const GoldenResult& result, nlohmann::ordered_json rows,
                                 const fs::path& out) {
    std::error_code failure;
    fs::create_directories(out, failure);
    if (failure)
        throw Error(ExitCode::other, "cannot write to the folder " + out.string() + ": " + failure.message());
    const fs::path path = out / "golden.html";
    nlohmann::ordered_json data;
    data["mark"] = own_mark;
    data["title"] = title_of(result);
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
    data["golden"] = page_part(result, std::move(rows), 24'000'000);
    write_file(path, page_text(data));
    return path;
}

}  // namespace cloth::pipeline
