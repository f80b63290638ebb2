#include "pipeline/scene_file/fabric_list.h"

#include <fmt/format.h>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "sim/energies/bending.h"
#include "sim/scene/fabrics.h"

namespace cloth::pipeline {

std::string unknown_fabric(const std::string& name) {
    std::vector<std::string> known;
    for (const NamedFabric& f : named_fabrics()) known.push_back(f.fabric.name);
    const std::string near = nearest_word(name, known);
    return fmt::format("there is no fabric \"{}\"; {}known: {}", name,
                       near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near), join(known));
}

std::string fabric_table() {
    // Stiffness as E h, bending as the textile trade states them.
    std::string text =
        fmt::format("{:<14}{:>7}{:>11} |{:>21} |{:>6}{:>7} |{:>18} |{:>7} |{:>14} |{:>9}\n", "", "weight",
                    "thickness", "stiffness [N/m]", "", "", "bending [µN m]", "bends", "damping [ms]", "");
    text += fmt::format(
        "{:<14}{:>7}{:>11} |{:>7}{:>7}{:>7} |{:>6}{:>7} |{:>6}{:>6}{:>6} |{:>7} |{:>7}{:>7} |{:>9}\n", "",
        "[g/m²]", "[mm]", "warp", "weft", "shear", "ν", "limit", "warp", "weft", "bias", "at [mm]", "stretch",
        "bend", "friction");
    for (const NamedFabric& named : named_fabrics()) {
        const Fabric& f = named.fabric;
        const double h = f.thickness, isotropic = 0.5 * f.young_modulus / (1.0 + f.poisson_ratio);
        text += fmt::format(
            "{:<14}{:>7.0f}{:>11.3g} |{:>7.0f}{:>7.0f}{:>7.0f} |{:>6.2f}{:>7.3f} |{:>6.3g}{:>6.3g}{:>6.3g} "
            "|{:>7.0f} |{:>7.0f}{:>7.0f} |{:>9.2f}\n",
            f.name, 1e3 * f.density, 1e3 * h, h * f.young_modulus, h * f.young_weft.value_or(f.young_modulus),
            h * f.shear_modulus.value_or(isotropic), f.poisson_ratio, f.strain_limit.value_or(0.0),
            1e6 * f.bending, 1e6 * f.bending_weft.value_or(f.bending), 1e6 * f.bending_bias.value_or(0.0),
            1e3 * bending_length(f), 1e3 * f.membrane_damping, 1e3 * f.bending_damping, f.friction);
    }
    return text;
}

std::string fabric_rows() {
    std::string text = "| fabric | | weight, g/m² | bending length, mm |\n|-|-|-:|-:|\n";
    for (const NamedFabric& named : named_fabrics()) {
        const Fabric& f = named.fabric;
        text += fmt::format("| `{}` | {} | {:.0f} | {:.0f} |\n", f.name, named.description, 1e3 * f.density,
                            1e3 * bending_length(f));
    }
    return text;
}

std::string fabric_sources(const std::string& name) {
    if (!name.empty() && !find_fabric(name)) throw Error(ExitCode::usage, unknown_fabric(name));
    std::string text;
    for (const NamedFabric& named : named_fabrics()) {
        if (!name.empty() && named.fabric.name != name) continue;
        text += fmt::format("{}{}: {}\n", text.empty() ? "" : "\n", named.fabric.name, named.description);
        for (const FabricValue& v : named.values) {
            std::string value = fmt::format("{:.4g}{}{}", v.value, v.unit.empty() ? "" : " ", v.unit);
            if (v.unit == "Pa") value += fmt::format(" ({:.4g} N/m wide)", v.value * named.fabric.thickness);
            text += fmt::format("  {:<17} {:<30} {}\n", v.key, value, v.source);
        }
    }
    return text;
}

}  // namespace cloth::pipeline
