#include "base/plot.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text.h"

namespace cloth {
namespace {

constexpr double width = 640, height = 420, left = 78, right = 20, top = 40, bottom = 58;
constexpr const char* colours[] = {"#1f5fa8", "#c0392b", "#2e8b57", "#8e44ad", "#b8860b"};

/// One axis: data → page, and where its ticks stand.
struct Axis {
    double low = 0.0, high = 1.0;
    bool logarithmic = false;
    double page_low = 0.0, page_high = 1.0;

    double value(double x) const { return logarithmic ? std::log10(x) : x; }
    double page(double x) const {
        return page_low + (value(x) - low) / (high - low) * (page_high - page_low);
    }
    std::vector<double> ticks() const {
        std::vector<double> list;
        if (logarithmic) {
            const int stride = std::max(1, static_cast<int>((high - low) / 6.0));
            for (int e = static_cast<int>(std::ceil(low - 1e-9)); e <= high + 1e-9; e += stride) {
                list.push_back(std::pow(10.0, e));
            }
            return list;
        }
        const double raw = (high - low) / 6.0, power = std::pow(10.0, std::floor(std::log10(raw)));
        const double step = power * (raw / power < 1.5   ? 1.0
                                     : raw / power < 3.5 ? 2.0
                                     : raw / power < 7.5 ? 5.0
                                                         : 10.0);
        for (double x = std::ceil(low / step) * step; x <= high + 1e-9 * step; x += step) {
            list.push_back(std::abs(x) < 1e-9 * step ? 0.0 : x);
        }
        return list;
    }
};

Axis make_axis(const Plot& plot, double PlotPoint::*coordinate, bool logarithmic) {
    Axis axis;
    axis.logarithmic = logarithmic;
    axis.low = 1e300;
    axis.high = -1e300;
    for (const Curve& curve : plot.curves) {
        for (const auto& p : curve.points) {
            if (!std::isfinite(p.*coordinate) || (logarithmic && p.*coordinate <= 0.0)) continue;
            axis.low = std::min(axis.low, axis.value(p.*coordinate));
            axis.high = std::max(axis.high, axis.value(p.*coordinate));
        }
    }
    if (axis.low > axis.high) axis.low = 0.0, axis.high = 1.0;
    const double margin = axis.high > axis.low ? 0.04 * (axis.high - axis.low) : 0.5;
    axis.low -= margin;
    axis.high += margin;
    return axis;
}

}  // namespace

std::string to_svg(const Plot& plot) {
    Axis x = make_axis(plot, &PlotPoint::x, plot.log_x), y = make_axis(plot, &PlotPoint::y, plot.log_y);
    x.page_low = left;
    x.page_high = width - right;
    y.page_low = height - bottom;
    y.page_high = top;

    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        width, height);
    auto text = [&](double at_x, double at_y, const char* anchor, const std::string& words,
                    const std::string& more = "") {
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", at_x, at_y,
                           anchor, more, escaped(words));
    };
    text(0.5 * (left + width - right), 22, "middle", plot.title, " font-size=\"15\" font-weight=\"bold\"");
    text(0.5 * (left + width - right), height - 12, "middle", plot.x_label);
    text(18, 0.5 * (top + height - bottom), "middle", plot.y_label,
         fmt::format(" transform=\"rotate(-90 18 {:.1f})\"", 0.5 * (top + height - bottom)));
    for (double tick : x.ticks()) {
        const double at = x.page(tick);
        svg += fmt::format("<line x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\" stroke=\"#ddd\"/>\n",
                           at, top, height - bottom);
        text(at, height - bottom + 18, "middle", fmt::format("{:g}", tick));
    }
    for (double tick : y.ticks()) {
        const double at = y.page(tick);
        svg += fmt::format("<line x1=\"{0}\" y1=\"{1:.1f}\" x2=\"{2}\" y2=\"{1:.1f}\" stroke=\"#ddd\"/>\n",
                           left, at, width - right);
        text(left - 8, at + 4, "end", fmt::format("{:g}", tick));
    }
    svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#444\"/>\n",
                       left, top, width - left - right, height - top - bottom);
    auto visible = [&](const PlotPoint& p) {
        return std::isfinite(p.x) && std::isfinite(p.y) && (!plot.log_x || p.x > 0.0) &&
               (!plot.log_y || p.y > 0.0);
    };
    for (std::size_t c = 0; c < plot.curves.size(); ++c) {
        const Curve& curve = plot.curves[c];
        const char* colour = colours[c % std::size(colours)];
        std::string line;
        for (const auto& p : curve.points) {
            if (!visible(p)) continue;
            if (curve.markers) {
                svg += fmt::format(
                    "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"white\" stroke=\"{}\" "
                    "stroke-width=\"2\"/>\n",
                    x.page(p.x), y.page(p.y), colour);
            } else {
                line += fmt::format("{}{:.1f},{:.1f}", line.empty() ? "" : " ", x.page(p.x), y.page(p.y));
            }
        }
        if (!line.empty()) {
            svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"/>\n",
                               line, colour);
        }
        const double key = top + 16 + 19 * static_cast<double>(c);
        svg += curve.markers
                   ? fmt::format(
                         "<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"white\" stroke=\"{}\" "
                         "stroke-width=\"2\"/>\n",
                         left + 22, key, colour)
                   : fmt::format(
                         "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                         left + 10, key, left + 34, key, colour);
        text(left + 42, key + 4, "start", curve.label);
    }
    return svg + "</svg>\n";
}

}  // namespace cloth
