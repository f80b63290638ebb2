#include "pipeline/golden/golden_page.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/run_folder.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

std::string base64(std::string_view bytes) {
    static constexpr std::string_view digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
        unsigned triple = 0;
        for (std::size_t k = 0; k < 3; ++k)
            triple = triple << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= n ? digits[triple >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

std::string picture_html(const render::Image& image, const std::string& caption) {
    const std::vector<std::uint8_t> png = render::encode_png(image);
    const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
    return fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption>"
        "</figure>\n",
        escaped(caption), base64(bytes));
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

std::string row_html(const GoldenRow& row, const render::Image* golden, const render::Image* actual) {
    std::string html = fmt::format(
        "<h2>Frame {}</h2>\n<p>State: <b>{}</b>, distance {} m. {}</p>\n<p>Picture: <b>{}</b>, PSNR {} dB, "
        "over 2: "
        "{:.3f} %, over 32: {:.3f} %, worst by {} of 255 at ({}, {}). {}</p>\n",
        row.frame, word(row.state.passed), distance_text(row.state), escaped(row.state.reason),
        word(row.image.passed), psnr_text(row.image), 100 * row.image.difference.fraction_over_2,
        100 * row.image.difference.fraction_over_32, row.image.difference.largest,
        row.image.difference.worst_x, row.image.difference.worst_y, escaped(row.image.reason));
    html += "<div class=\"row\">\n";
    if (golden != nullptr) html += picture_html(*golden, "golden");
    if (actual != nullptr) html += picture_html(*actual, "actual");
    if (golden != nullptr && actual != nullptr && row.image.difference.same_size)
        html += picture_html(render::magnified_difference(*golden, *actual, 16), "difference, times 16");
    return html + "</div>\n";
}

std::filesystem::path write_page(const GoldenResult& result, const std::string& rows, const fs::path& out) {
    std::error_code failure;
    fs::create_directories(out, failure);
    if (failure)
        throw Error(ExitCode::other, "cannot write to the folder " + out.string() + ": " + failure.message());
    const fs::path path = out / "golden.html";
    const std::string title =
        fmt::format("{}: golden frames {}", result.scene, result.passed ? "agree" : "differ");
    write_file(
        path, fmt::format(
                  "<!DOCTYPE html>\n{8}\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
                  "<style>body{{font:15px sans-serif;margin:2em}}.row{{display:flex;gap:8px;flex-wrap:wrap}}"
                  "figure{{margin:0}}img{{image-rendering:pixelated}}pre{{background:#eee;padding:1em}}"
                  "</style></head><body>\n<h1>{0}</h1>\n<table>\n"
                  "<tr><td>golden build</td><td>{1}</td></tr>\n<tr><td>this build</td><td>{2}</td></tr>\n"
                  "<tr><td>golden renderer</td><td>{3}</td></tr>\n"
                  "<tr><td>this renderer</td><td>{4}</td></tr>\n</table>\n<pre>{5}</pre>\n"
                  "<p>Pictures are drawn from the golden states. If the change is wanted:</p>\n"
                  "<pre>{6}</pre>\n{7}</body></html>\n",
                  escaped(title), escaped(result.golden_build), escaped(result.actual_build),
                  escaped(result.golden_renderer), escaped(result.actual_renderer),
                  escaped(golden_table(result)), escaped(bless_command(result.scene)), rows, own_mark));
    return path;
}

}  // namespace cloth::pipeline
