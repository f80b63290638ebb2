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

// ln 2 as a number of 32 bits, whose small multiples are exact, and the rest.
constexpr double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;

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

double portable_exp(double x) {
    if (x > 710.0) return HUGE_VAL;
    if (x < -746.0) return 0.0;
    const double n = std::floor(x / (ln2_high + ln2_low) + 0.5);
    const double r = (x - n * ln2_high) - n * ln2_low;
    double sum = 1.0;  // Taylor series; the first term left out is below 1e-18 for |r| ≤ ln(2)/2
    for (int k = 15; k >= 1; --k) sum = 1.0 + r / k * sum;
    return std::ldexp(sum, static_cast<int>(n));
}

double portable_log(double x) {
    int power = 0;
    double m = std::frexp(x, &power);
    if (m < 0.70710678118654752440) {
        m *= 2.0;
        --power;
    }
    // log(m) = 2 artanh(s); the first term left out is below 1e-20 for |s| ≤ 0.172
    const double s = (m - 1.0) / (m + 1.0), y = s * s;
    double sum = 0.0;
    for (int k = 25; k >= 3; k -= 2) sum = (sum + 1.0 / k) * y;
    return power * ln2_high + (power * ln2_low + 2.0 * (s + s * sum));
}

}  // namespace cloth
