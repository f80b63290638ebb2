#pragma once
// Fabrics by name: values in SI, each with its source.
//
// The tensile stiffnesses are those of low loads (E h [N/m], as cloth under its own weight feels it); where
// the threads have straightened the strain limit takes over. Bending rigidities are those of KES-F and of
// fits to cantilevers and drape [N m]: 1 gf cm²/cm = 98.1 µN m; shear 1 gf/(cm degree) = 56.2 N/m. Hysteresis
// is a friction between threads; the damping times are those of the viscous material that loses as much per
// cycle at 3 Hz, τ = η / (2π 3 Hz), with η = 2 (2HB) / (π B κ) at κ = 1/cm in bending, η = 2 (1 - RT) / π in
// stretch.

#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace cloth {

/// One number of a fabric, in the unit and under the key of a scene file.
struct FabricValue {
    std::string key, unit;
    double value;
    std::string source;
};

struct NamedFabric {
    Fabric fabric;
    std::string description;
    std::vector<FabricValue> values;  ///< every number of `fabric`
};

/// The table, in alphabetical order.
const std::vector<NamedFabric>& named_fabrics();

/// Null for an unknown name.
const NamedFabric* find_fabric(const std::string& name);

}  // namespace cloth
