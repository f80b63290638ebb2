#include "pipeline/formats/arcsim_fabric.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/formats/error.h"
#include "pipeline/formats/json_file.h"
#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {
namespace {

using nlohmann::json;

/// Rows of numbers under a key.
template <std::size_t Rows, std::size_t Columns>
std::array<std::array<double, Columns>, Rows> numbers(const json& file, const char* key,
                                                      const FilePlace& place) {
    std::array<std::array<double, Columns>, Rows> all{};
    const auto refuse = [&] {
        place.fail(
            fmt::format("{} is not {} rows of {} numbers, as ARCSim's fabrics have it", key, Rows, Columns));
    };
    const auto found = file.find(key);
    if (found == file.end() || !found->is_array() || found->size() != Rows) refuse();
    for (std::size_t r = 0; r < Rows; ++r) {
        const json& row = (*found)[r];
        if (!row.is_array() || row.size() != Columns) refuse();
        for (std::size_t c = 0; c < Columns; ++c) {
            if (!row[c].is_number()) refuse();
            all[r][c] = row[c].get<double>();
        }
    }
    return all;
}

}  // namespace

LoadedFabric read_arcsim_fabric(const std::filesystem::path& path) {
    const FilePlace place{path};
    const json file = read_json_object(path);
    const auto density = file.find("density");
    if (density == file.end() || !density->is_number())
        place.fail("has no number density [kg/m²], as ARCSim's fabrics have it");
    const auto stretching = numbers<6, 4>(file, "stretching", place);
    const auto bending = numbers<3, 5>(file, "bending", place);
    const auto [c11, c12, c22, c33] = stretching[0];
    if (!(c11 > 0.0 && c22 > 0.0 && c33 > 0.0 && c11 * c22 > c12 * c12))
        place.fail(
            fmt::format("stretching at rest, {:g}, {:g}, {:g}, {:g} N/m, is no stiffness: it would "
                        "give energy to who stretches the cloth",
                        c11, c12, c22, c33));

    LoadedFabric loaded;
    Fabric& f = loaded.fabric;
    f.name = path.stem().string();
    f.density = density->get<double>();
    f.thickness = 1e-3;
    f.membrane = MembraneKind::st_venant_kirchhoff;
    f.young_modulus = (c11 - c12 * c12 / c22) / f.thickness;
    f.young_weft = (c22 - c12 * c12 / c11) / f.thickness;
    f.poisson_ratio = c12 / c22;
    f.shear_modulus = 0.25 * c33 / f.thickness;
    f.bending = bending[0][0];
    f.bending_weft = bending[2][0];
    f.bending_bias = bending[1][0];
    loaded.notes.push_back(
        "how it stiffens under strain (stretching, rows 2 to 6) and curvature (bending, columns 2 to 5) has "
        "no place here and is left out; friction and strain limit, of which the file says nothing, are none");
    const double least = 0.25 * (f.bending + *f.bending_weft);
    if (*f.bending_bias < least) {
        loaded.notes.push_back(
            fmt::format("its rigidity at 45 degrees, {:g} N m, is less than a sheet can have beside {:g} and "
                        "{:g}; {:g} taken",
                        *f.bending_bias, f.bending, *f.bending_weft, least));
        f.bending_bias = least;
    }
    return loaded;
}

}  // namespace cloth::pipeline
