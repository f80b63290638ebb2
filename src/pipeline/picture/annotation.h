#pragma once
// What is drawn over a finished picture: captions, a colour legend, curves. Sizes follow the picture's
// height; nothing overlaps: captions stand at the bottom left, the legend at the right, curves at the top
// left.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace cloth::pipeline {

/// Height of an em for a picture of this size [pixel].
float text_size(int width, int height);

/// Between `low` and `high`, at multiples of 1, 2 or 5 times a power of ten, at most `most` of them.
std::vector<double> ticks(double low, double high, int most);
/// Ticks as numbers of as many decimals as tell them apart.
std::vector<std::string> tick_labels(const std::vector<double>& ticks);

/// {scene}, {time}, {frame} and {description} of `text` filled in.
std::string fill_caption(const std::string& text, const std::string& scene, const std::string& description,
                         double time, std::int64_t frame);

/// At the bottom left, cut to the picture's width by an ellipsis.
void draw_caption(render::Image& image, const std::string& text);
/// At the top, in the middle: which of several pictures this is.
void draw_label(render::Image& image, const std::string& text);

struct Legend {
    std::string title;  ///< with its unit
    double low = 0, high = 1;
    bool below = false, above = false;  ///< whether numbers beyond an end are shown in its colour
};
/// A colour bar along the right edge. Returns the column where its panel begins; the picture's width where
/// there is no room for it.
int draw_legend(render::Image& image, const Legend& legend);

struct CurveLine {
    std::string title;           ///< with its unit
    std::vector<double> values;  ///< one per entry of the times; NaN where unknown
};
/// One panel for each line, over the whole run: faint up to its end, strong up to `now`, where a dot and the
/// number stand. As many as find room.
void draw_curves(render::Image& image, const std::vector<double>& times, const std::vector<CurveLine>& lines,
                 double now);

}  // namespace cloth::pipeline
