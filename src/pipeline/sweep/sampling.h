#pragma once
// Random samples that are the same numbers on every machine, and of which each depends on the seed, the key
// and its own number alone: more samples, or more keys, change none that are there.
//
// Draw d of sample k of a key: u = (h + 1/2) / 2^52 with h the upper 52 bits of
//   hash = mix(mix(mix(mix(seed) ^ FNV-1a(key)) + k) + d)
// where mix is SplitMix64's finaliser behind its increment (Steele, Lea, Flood 2014). All else is made of u
// by inverse distribution functions from additions, multiplications and square roots (base/portable_math.h).

#include <cstdint>
#include <string>
#include <vector>

namespace cloth::pipeline {

/// Even over the open interval (0, 1).
double unit_sample(std::uint64_t seed, const std::string& key, std::int64_t sample, std::int64_t draw);

/// Inverse of the standard normal distribution function, for 0 < p < 1, within 1e-15 relatively (Wichura
/// 1988, AS 241).
double normal_quantile(double p);

enum class DistributionKind { uniform, log_uniform, normal, choice, integer };

struct Distribution {
    DistributionKind kind = DistributionKind::uniform;
    double low = 0, high = 1;            ///< of uniform, log_uniform, integer (both ends can come)
    double mean = 0, deviation = 1;      ///< of normal; what lies outside of low … high is drawn again
    std::vector<std::string> choices{};  ///< TOML values
    std::vector<double> weights{};       ///< one per choice; empty: all alike
    bool low_said = false, high_said = false;  ///< of normal
};

/// Sample number `sample` of a key, as a TOML value. Throws std::runtime_error where a thousand draws of a
/// normal distribution all lie outside of its bounds.
std::string sample_text(const Distribution& distribution, std::uint64_t seed, const std::string& key,
                        std::int64_t sample);

}  // namespace cloth::pipeline
