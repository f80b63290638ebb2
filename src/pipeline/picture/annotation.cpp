#include "pipeline/picture/annotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "render/image/colormap.h"
#include "render/overlay/overlay.h"

namespace cloth::pipeline {
namespace {

using render::Float2;
using render::Ink;

const Ink dark{{28, 32, 38}}, panel{{255, 255, 255}, 0.78f}, faint{{28, 32, 38}, 0.28f},
    accent{{196, 50, 30}};

/// The longest beginning of `text` that is no wider than `room`, with an ellipsis where something is left
/// out.
std::string fitted(const std::string& text, float size, float room) {
    if (render::text_width(text, size) <= room) return text;
    std::string cut = text;
    while (!cut.empty()) {
        do cut.pop_back();
        while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xc0) == 0x80);
        // A lead byte alone is no letter.
        if (!cut.empty() && static_cast<unsigned char>(cut.back()) >= 0xc0) cut.pop_back();
        if (render::text_width(cut + "…", size) <= room) return cut + "…";
    }
    return "";
}

struct Box {
    float x0, y0, x1, y1;
};

/// A line of text on a panel of its own, its box's corner at (x, y).
Box draw_panel_text(render::Image& image, float x, float y, const std::string& text, float size) {
    const float pad = 0.5f * size;
    const Box box{x, y, x + render::text_width(text, size) + 2 * pad,
                  y + render::capital_height(size) + 2 * pad};
    render::fill_rectangle(image, {box.x0, box.y0}, {box.x1, box.y1}, panel);
    render::draw_text(image, {box.x0 + pad, box.y1 - pad}, text, size, dark);
    return box;
}

/// Rows at the bottom that are left to captions.
float caption_band(float size) {
    return 2.4f * size + render::capital_height(size);
}

std::string short_number(double value) {
    if (!std::isfinite(value)) return "–";
    const double size = std::abs(value);
    if (value == std::round(value) && size < 1e6) return fmt::format("{:.0f}", value);
    if (size >= 1e5 || (size > 0 && size < 1e-4)) return fmt::format("{:.2e}", value);
    const int before = size >= 1 ? static_cast<int>(std::floor(std::log10(size))) : 0;
    return fmt::format("{:.{}f}", value, std::max(0, 3 - before));
}

}  // namespace

float text_size(int width, int height) {
    return std::clamp(std::min(static_cast<float>(height) / 42.0f, static_cast<float>(width) / 60.0f), 11.0f,
                      64.0f);
}

std::vector<double> ticks(double low, double high, int most) {
    std::vector<double> places;
    if (!(high > low) || most < 1 || !std::isfinite(high - low)) return places;
    const double power = std::pow(10.0, std::floor(std::log10((high - low) / most)));
    double step = power;
    for (const double factor : {1.0, 2.0, 5.0, 10.0, 20.0}) {
        step = factor * power;
        if (std::floor(high / step + 1e-9) - std::ceil(low / step - 1e-9) < most) break;
    }
    for (double k = std::ceil(low / step - 1e-9); k <= std::floor(high / step + 1e-9); ++k)
        places.push_back(k == 0 ? 0.0 : k * step);
    return places;
}

std::vector<std::string> tick_labels(const std::vector<double>& places) {
    std::vector<std::string> labels;
    if (places.empty()) return labels;
    double largest = 0, finest = 0;
    for (const double p : places) largest = std::max(largest, std::abs(p));
    for (std::size_t i = 1; i < places.size(); ++i) {
        const double step = std::abs(places[i] - places[i - 1]);
        finest = i == 1 ? step : std::min(finest, step);
    }
    if (finest == 0) finest = std::max(largest, 1e-300);
    // As many digits as tell each to a thousandth of the finest step
    const bool powers = largest >= 1e5 || finest < 1e-4 * (1 - 1e-9);
    for (int decimals = 0; decimals <= 6; ++decimals) {
        labels.clear();
        for (const double p : places)
            labels.push_back(powers && p != 0 ? fmt::format("{:.{}e}", p, decimals)
                                              : fmt::format("{:.{}f}", p, powers ? 0 : decimals));
        bool told = true;
        for (std::size_t i = 0; i < places.size(); ++i)
            told = told && std::abs(std::stod(labels[i]) - places[i]) < 1e-3 * finest;
        if (told) break;
    }
    return labels;
}

std::string fill_caption(const std::string& text, const std::string& scene, const std::string& description,
                         double time, std::int64_t frame) {
    std::string filled;
    for (std::size_t at = 0; at < text.size();) {
        const auto put = [&](std::string_view name, const std::string& value) {
            if (text.compare(at, name.size(), name) != 0) return false;
            filled += value;
            at += name.size();
            return true;
        };
        if (put("{scene}", scene) || put("{description}", description) ||
            put("{time}", fmt::format("{:.3f}", time)) || put("{frame}", fmt::format("{}", frame)))
            continue;
        filled += text[at++];
    }
    return filled;
}

void draw_caption(render::Image& image, const std::string& text) {
    const float size = text_size(image.width, image.height), margin = 0.7f * size;
    const auto width = static_cast<float>(image.width), height = static_cast<float>(image.height);
    const std::string line = fitted(text, size, width - 2 * margin - size);
    if (line.empty()) return;
    draw_panel_text(image, margin, height - margin - render::capital_height(size) - size, line, size);
}

void draw_label(render::Image& image, const std::string& text) {
    const float size = 1.15f * text_size(image.width, image.height), margin = 0.7f * size;
    const auto width = static_cast<float>(image.width);
    const std::string line = fitted(text, size, width - 2 * margin - size);
    if (line.empty()) return;
    draw_panel_text(image, std::round(0.5f * (width - render::text_width(line, size) - size)), margin, line,
                    size);
}

int draw_legend(render::Image& image, const Legend& legend) {
    const float size = text_size(image.width, image.height), margin = 0.7f * size, pad = 0.6f * size;
    const auto width = static_cast<float>(image.width), height = static_cast<float>(image.height);
    const float bar = std::round(0.9f * size), gap = 0.45f * size, capital = render::capital_height(size);
    const float head = capital + 0.9f * size;
    const float lowest = height - caption_band(size);  // captions may be as wide as the picture
    const float length = std::floor(std::min({0.55f * height, 18 * size, lowest - margin - head - 2 * pad}));
    if (length < 3 * size) return image.width;
    const int most = std::clamp(static_cast<int>(length / (2.2f * size)), 1, 8);
    std::vector<double> places = ticks(legend.low, legend.high, most);
    // The ends of the scale are always told; what stands too near to them gives way.
    const double room = 1.5 * static_cast<double>(size / length) * (legend.high - legend.low);
    std::erase_if(places, [&](double p) { return p - legend.low < room || legend.high - p < room; });
    places.insert(places.begin(), legend.low);
    places.push_back(legend.high);
    std::vector<std::string> labels = tick_labels(places);
    float widest = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const double slack = 1e-6 * (legend.high - legend.low);
        if (legend.below && places[i] <= legend.low + slack) labels[i] = "≤ " + labels[i];
        if (legend.above && places[i] >= legend.high - slack) labels[i] = "≥ " + labels[i];
        widest = std::max(widest, render::text_width(labels[i], size));
    }
    const float inner = std::max(bar + gap + widest, render::text_width(legend.title, size));
    const float tall = length + head + 2 * pad;
    const float y = std::min(std::round(0.5f * (height - tall)), std::floor(lowest - tall));
    const Box box{width - margin - inner - 2 * pad, y, width - margin, y + tall};
    if (box.x0 < 0 || box.y0 < 0) return image.width;
    render::fill_rectangle(image, {box.x0, box.y0}, {box.x1, box.y1}, panel);
    const float left = std::round(box.x0 + pad), top = std::round(box.y0 + pad + head);
    render::draw_text(image, {left, box.y0 + pad + capital}, legend.title, size, dark);
    for (int row = 0; row < static_cast<int>(length); ++row) {
        const double share = 1.0 - (row + 0.5) / static_cast<double>(length);
        const float at = top + static_cast<float>(row);
        render::fill_rectangle(image, {left, at}, {left + bar, at + 1}, Ink{render::viridis(share)});
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double share = (places[i] - legend.low) / (legend.high - legend.low);
        const float at = top + length * static_cast<float>(1.0 - share);
        render::fill_rectangle(image, {left + bar, at - 0.5f}, {left + bar + 0.3f * size, at + 0.5f}, dark);
        render::draw_text(image, {left + bar + gap, at + 0.5f * capital}, labels[i], size, dark);
    }
    return static_cast<int>(box.x0);
}

void draw_curves(render::Image& image, const std::vector<double>& times, const std::vector<CurveLine>& lines,
                 double now) {
    const float size = text_size(image.width, image.height), margin = 0.7f * size, pad = 0.5f * size;
    const auto width = static_cast<float>(image.width), height = static_cast<float>(image.height);
    const float panel_width = std::round(std::min(std::max(0.24f * width, 10 * size), width - 2 * margin));
    const float plot = std::round(std::clamp(0.075f * height, 2 * size, 3.2f * size));
    const float capital = render::capital_height(size), head = capital + 0.6f * size;
    const float panel_height = head + plot + 2 * pad;
    if (times.empty()) return;
    float y = margin;
    for (const CurveLine& line : lines) {
        if (y + panel_height > height - caption_band(size)) return;  // no room for more
        const Box box{margin, y, margin + panel_width, y + panel_height};
        y += panel_height + 0.5f * margin;
        render::fill_rectangle(image, {box.x0, box.y0}, {box.x1, box.y1}, panel);

        double low = INFINITY, high = -INFINITY, here = NAN;
        for (std::size_t i = 0; i < times.size(); ++i) {
            const double value = line.values.at(i);
            if (!std::isfinite(value)) continue;
            low = std::min(low, value);
            high = std::max(high, value);
            if (times[i] <= now + 1e-9) here = value;
        }
        const float base = box.y0 + pad + capital, right = box.x1 - pad;
        const std::string number = short_number(here);
        const float number_width = render::text_width(number, size);
        render::draw_text(image, {box.x0 + pad, base},
                          fitted(line.title, size, panel_width - 3 * pad - number_width), size, dark);
        render::draw_text(image, {right - number_width, base}, number, size, accent);
        if (!(high >= low)) continue;
        const double room = high > low ? high - low : std::max(std::abs(high), 1.0);
        const double first = times.front(), span = std::max(times.back() - first, 1e-12);
        const float x0 = box.x0 + pad, x1 = right, y1 = box.y1 - pad, y0 = y1 - plot;
        const auto place = [&](std::size_t i) {
            return Float2{x0 + static_cast<float>((times[i] - first) / span) * (x1 - x0),
                          y1 - static_cast<float>((line.values[i] - low) / room) * (y1 - y0)};
        };
        render::fill_rectangle(image, {x0, y1}, {x1, y1 + 1}, faint);
        std::vector<Float2> points;
        Float2 head_point{NAN, NAN};
        const float stroke = std::max(1.0f, 0.1f * size);
        const auto flush = [&](const Ink& ink, float thickness) {
            if (points.size() > 1) render::draw_polyline(image, points, thickness, ink);
            points.clear();
        };
        for (const bool done : {false, true}) {
            for (std::size_t i = 0; i < times.size(); ++i) {
                const bool wanted = !done || times[i] <= now + 1e-9;
                if (!std::isfinite(line.values[i]) || !wanted) {
                    flush(done ? dark : faint, stroke);
                    continue;
                }
                points.push_back(place(i));
                if (done) head_point = points.back();
            }
            flush(done ? dark : faint, stroke);
        }
        if (std::isfinite(head_point[0]))
            render::draw_polyline(image, std::vector<Float2>{head_point}, 0.45f * size, accent);
    }
}

}  // namespace cloth::pipeline
