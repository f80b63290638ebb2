#pragma once
// Physical checks of the simulator: each runs scenes, measures, and compares with theory or measurement.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/plot.h"
#include "sim/scene/scene.h"

namespace cloth::validation {

/// One line of the table.
struct Finding {
    std::string check;     ///< "cantilever"
    std::string quantity;  ///< "H/W at Gamma 8"
    double measured = 0.0;
    double expected = 0.0;
    double tolerance = 0.0;  ///< largest |measured - expected|, in the quantity's own unit
    std::string unit;        ///< "", "m", "s", …
    std::string source;      ///< where `expected` comes from
    /// For bands and one-sided bounds, `expected` ± `tolerance` is the band.
    bool good() const;
};

struct Outcome {
    std::vector<Finding> findings;
    std::vector<Plot> plots;
};

/// Parameters that a user may set; a check ignores those that it does not have.
struct Parameters {
    std::optional<double> gamma;        ///< cantilever: this load alone
    std::optional<int> resolution;      ///< elements along the longest side
    std::optional<std::string> fabric;  ///< drape: this fabric alone
};

struct Check {
    std::string name;
    std::string about;                    ///< one line
    std::vector<std::string> parameters;  ///< those it has: "gamma", "resolution", "fabric"
    std::function<Outcome(const Parameters&)> run;
};

/// The table's head, and a line of it, each with its line ends.
std::string table_head(bool markdown);
std::string table_line(const Finding& finding, bool markdown);

/// All checks, in the order of the table.
const std::vector<Check>& checks();

/// Drape coefficient [%] of a disc of 30 cm over a pedestal of 18 cm, whose top holds the cloth on it: the
/// share of the overhanging ring's area that its shadow keeps. (Cusick 1968; BS 5058.)
double cusick_drape_coefficient(const Fabric& fabric, int rings);

Outcome check_cantilever(const Parameters& parameters);
Outcome check_lateral_buckling(const Parameters& parameters);
Outcome check_catenary(const Parameters& parameters);
Outcome check_own_weight(const Parameters& parameters);
Outcome check_pendulum(const Parameters& parameters);
Outcome check_vibration(const Parameters& parameters);
Outcome check_wave_speed(const Parameters& parameters);
Outcome check_momentum(const Parameters& parameters);
Outcome check_energy(const Parameters& parameters);
Outcome check_time_order(const Parameters& parameters);
Outcome check_space_order(const Parameters& parameters);
Outcome check_diagonals(const Parameters& parameters);
Outcome check_rest(const Parameters& parameters);
Outcome check_drape(const Parameters& parameters);

}  // namespace cloth::validation
