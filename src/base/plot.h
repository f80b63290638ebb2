#pragma once
// Line plots as SVG.

#include <string>
#include <vector>

namespace cloth {

struct PlotPoint {
    double x = 0, y = 0;
};

struct Curve {
    std::string label;
    std::vector<PlotPoint> points;
    bool markers = false;  ///< circles instead of a line
};

struct Plot {
    std::string name;  ///< file name without extension
    std::string title, x_label, y_label;
    bool log_x = false, log_y = false;
    std::vector<Curve> curves;
};

/// The whole SVG file. Points that a logarithmic axis cannot show are left out.
std::string to_svg(const Plot& plot);

}  // namespace cloth
