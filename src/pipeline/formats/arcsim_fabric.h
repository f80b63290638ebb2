#pragma once
// Fabrics as ARCSim has them: the files of measured cloth of Wang, O'Brien and Ramamoorthi 2011, Data-Driven
// Elastic Models for Cloth: Modeling and Measurement.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace cloth::pipeline {

struct LoadedFabric {
    Fabric fabric;
    std::vector<std::string> notes;  ///< what the file has and a Fabric does not
};

/// A JSON file of "density" [kg/m²], "stretching", six rows of the stiffness C11, C12, C22, C33 [N/m] - at
/// rest, then strained in five directions -, and "bending", three rows, at 0, 45 and 90 degrees, of the
/// rigidity at five curvatures [N m]. The energy per area is ½ (C11 E11² + 2 C12 E11 E22 + C22 E22² + C33
/// E12²), E the Green strain, so that the shear modulus times the thickness is C33/4. The rows at rest and at
/// the least curvature are taken; their first direction is the warp. Throws Error(invalid_scene).
LoadedFabric read_arcsim_fabric(const std::filesystem::path& path);

}  // namespace cloth::pipeline
