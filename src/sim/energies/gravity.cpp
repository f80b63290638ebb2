#include "sim/energies/gravity.h"

namespace cloth {

GravityEnergy::GravityEnergy(const VecX& masses, const Vec3& gravity) : weight_(3 * masses.size()) {
    for (int i = 0; i < masses.size(); ++i) weight_.segment<3>(3 * i) = -masses(i) * gravity;
}

}  // namespace cloth
