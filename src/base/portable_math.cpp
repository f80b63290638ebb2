#include "base/portable_math.h"

#include <cmath>

namespace cloth {
namespace {

constexpr double radians_per_degree = 0.017453292519943295769;

// Taylor series; the first term left out is below 2e-17 for |x| ≤ π/4.
double sin_small(double x) {
    const double y = x * x;
    double sum = 0.0;
    for (int k = 19; k >= 3; k -= 2) sum = (sum + 1.0) * (-y / ((k - 1) * k));
    return x + x * sum;
}

double cos_small(double x) {
    const double y = x * x;
    double sum = 0.0;
    for (int k = 20; k >= 2; k -= 2) sum = (sum + 1.0) * (-y / ((k - 1) * k));
    return 1.0 + sum;
}

}  // namespace

double sin_degrees(double degrees) {
    const double quarter = std::floor(degrees / 90.0 + 0.5);
    const double x = (degrees - 90.0 * quarter) * radians_per_degree;
    switch (static_cast<long long>(quarter) & 3) {
        case 0:
            return sin_small(x);
        case 1:
            return cos_small(x);
        case 2:
            return -sin_small(x);
        default:
            return -cos_small(x);
    }
}

double cos_degrees(double degrees) {
    return sin_degrees(degrees + 90.0);
}

double tan_degrees(double degrees) {
    return sin_degrees(degrees) / cos_degrees(degrees);
}

}  // namespace cloth
