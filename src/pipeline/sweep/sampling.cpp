#include "pipeline/sweep/sampling.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/portable_math.h"
#include "pipeline/scene_file/toml_value.h"

namespace cloth::pipeline {
namespace {

std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
}

std::uint64_t fnv1a(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return hash;
}

/// c[0] + c[1] x + …
template <std::size_t N>
double polynomial(const double (&c)[N], double x) {
    double sum = c[N - 1];
    for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
    return sum;
}

}  // namespace

double unit_sample(std::uint64_t seed, const std::string& key, std::int64_t sample, std::int64_t draw) {
    std::uint64_t hash = mixed(mixed(seed) ^ fnv1a(key));
    hash = mixed(mixed(hash + static_cast<std::uint64_t>(sample)) + static_cast<std::uint64_t>(draw));
    return (static_cast<double>(hash >> 12) + 0.5) * 0x1p-52;
}

double normal_quantile(double p) {
    static constexpr double a[] = {3.3871328727963666080e0,  1.3314166789178437745e+2,
                                   1.9715909503065514427e+3, 1.3731693765509461125e+4,
                                   4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                   3.3430575583588128105e+4, 2.5090809287301226727e+3};
    static constexpr double b[] = {1.0,
                                   4.2313330701600911252e+1,
                                   6.8718700749205790830e+2,
                                   5.3941960214247511077e+3,
                                   2.1213794301586595867e+4,
                                   3.9307895800092710610e+4,
                                   2.8729085735721942674e+4,
                                   5.2264952788528545610e+3};
    static constexpr double c[] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                   5.76949722146069140550e0,  3.64784832476320460504e0,
                                   1.27045825245236838258e0,  2.41780725177450611770e-1,
                                   2.27238449892691845833e-2, 7.74545014278341407640e-4};
    static constexpr double d[] = {1.0,
                                   2.05319162663775882187e0,
                                   1.67638483018380384940e0,
                                   6.89767334985100004550e-1,
                                   1.48103976427480074590e-1,
                                   1.51986665636164571966e-2,
                                   5.47593808499534494600e-4,
                                   1.05075007164441684324e-9};
    static constexpr double e[] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                   1.78482653991729133580e0,  2.96560571828504891230e-1,
                                   2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                   2.71155556874348757815e-5, 2.01033439929228813265e-7};
    static constexpr double f[] = {1.0,
                                   5.99832206555887937690e-1,
                                   1.36929880922735805310e-1,
                                   1.48753612908506148525e-2,
                                   7.86869131145613259100e-4,
                                   1.84631831751005468180e-5,
                                   1.42151175831644588870e-7,
                                   2.04426310338993978564e-15};
    const double q = p - 0.5;
    if (std::abs(q) <= 0.425) {
        const double r = 0.180625 - q * q;
        return q * polynomial(a, r) / polynomial(b, r);
    }
    const double r = std::sqrt(-portable_log(q < 0 ? p : 1.0 - p));
    const double x = r <= 5.0 ? polynomial(c, r - 1.6) / polynomial(d, r - 1.6)
                              : polynomial(e, r - 5.0) / polynomial(f, r - 5.0);
    return q < 0 ? -x : x;
}

std::string sample_text(const Distribution& from, std::uint64_t seed, const std::string& key,
                        std::int64_t sample) {
    const auto unit = [&](std::int64_t draw) { return unit_sample(seed, key, sample, draw); };
    switch (from.kind) {
        case DistributionKind::uniform:
            return digits(std::clamp(from.low + unit(0) * (from.high - from.low), from.low, from.high));
        case DistributionKind::log_uniform: {
            const double low = portable_log(from.low), high = portable_log(from.high);
            return digits(std::clamp(portable_exp(low + unit(0) * (high - low)), from.low, from.high));
        }
        case DistributionKind::normal:
            for (std::int64_t draw = 0; draw < 1000; ++draw) {
                const double value = from.mean + from.deviation * normal_quantile(unit(draw));
                if ((!from.low_said || value >= from.low) && (!from.high_said || value <= from.high))
                    return digits(value);
            }
            throw std::runtime_error(fmt::format(
                "a thousand draws of sample {} all lie outside of {:g} … {:g}", sample, from.low, from.high));
        case DistributionKind::integer: {
            const double value = from.low + std::floor(unit(0) * (from.high - from.low + 1));
            return std::to_string(static_cast<std::int64_t>(std::min(value, from.high)));
        }
        case DistributionKind::choice:
            break;
    }
    if (from.weights.empty()) {
        const auto count = static_cast<double>(from.choices.size());
        return from.choices.at(static_cast<std::size_t>(std::min(unit(0) * count, count - 1)));
    }
    double left = unit(0) * std::accumulate(from.weights.begin(), from.weights.end(), 0.0);
    std::size_t last = 0;
    for (std::size_t i = 0; i < from.weights.size(); ++i) {
        if (from.weights[i] <= 0) continue;
        last = i;
        if (left < from.weights[i]) break;
        left -= from.weights[i];
    }
    return from.choices.at(last);
}

}  // namespace cloth::pipeline
