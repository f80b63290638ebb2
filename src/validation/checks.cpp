#include <cmath>

#include <fmt/format.h>

#include "validation/validation.h"

namespace cloth::validation {

bool Finding::good() const {
    return std::isfinite(measured) && std::abs(measured - expected) <= tolerance;
}

std::string table_head(bool markdown) {
    if (markdown) {
        return "| check | quantity | measured | expected | tolerance | unit | source | |\n"
               "|---|---|--:|--:|--:|---|---|---|\n";
    }
    return fmt::format("{:<17} {:<54} {:>12} {:>12} {:>10}  {:<12} {:<5} {}\n", "check", "quantity",
                       "measured", "expected", "tolerance", "unit", "", "source");
}

std::string table_line(const Finding& f, bool markdown) {
    const char* verdict = f.good() ? "good" : "BAD";
    if (markdown) {
        return fmt::format("| {} | {} | {:.6g} | {:.6g} | {:.2g} | {} | {} | {} |\n", f.check, f.quantity,
                           f.measured, f.expected, f.tolerance, f.unit, f.source, verdict);
    }
    return fmt::format("{:<17} {:<54} {:>12.6g} {:>12.6g} {:>10.2g}  {:<12} {:<5} {}\n", f.check, f.quantity,
                       f.measured, f.expected, f.tolerance, f.unit, verdict, f.source);
}

const std::vector<Check>& checks() {
    static const std::vector<Check> list{
        {"cantilever",
         "a strip clamped level at one end bends as the heavy elastica",
         {"gamma", "resolution"},
         check_cantilever},
        {"lateral_buckling",
         "a strip set on edge buckles sideways at its critical load",
         {"resolution"},
         check_lateral_buckling},
        {"catenary", "a hanging strip's sag and tension", {"resolution"}, check_catenary},
        {"pendulum", "the period of a hanging sheet", {"resolution"}, check_pendulum},
        {"vibration", "a cantilever's first three frequencies", {"resolution"}, check_vibration},
        {"wave_speed", "waves in the sheet's plane", {"resolution"}, check_wave_speed},
        {"own_weight", "a hanging strip's lengthening", {"resolution"}, check_own_weight},
        {"momentum", "momentum of a free sheet", {"resolution"}, check_momentum},
        {"energy", "energy of a swinging sheet", {"resolution"}, check_energy},
        {"time_order", "order of the integrators", {"resolution"}, check_time_order},
        {"space_order", "order of the cantilever's error in the mesh size", {}, check_space_order},
        {"diagonals",
         "the answer does not hang on the direction of the grid's diagonals",
         {"resolution"},
         check_diagonals},
        {"rest", "a cotton sheet at 1/60 s stays at rest over 10,000 steps", {"resolution"}, check_rest},
        {"drape",
         "drape coefficients of fabrics on Cusick's drapemeter",
         {"fabric", "resolution"},
         check_drape},
    };
    return list;
}

}  // namespace cloth::validation
