// Samples: the same numbers everywhere, distributed as they say.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "pipeline/sweep/sampling.h"

using namespace cloth::pipeline;

namespace {

Distribution between(DistributionKind kind, double low, double high) {
    Distribution d;
    d.kind = kind;
    d.low = low;
    d.high = high;
    return d;
}

double number(const Distribution& d, std::int64_t k) {
    return std::stod(sample_text(d, 7, "cloth.fabric.bending", k));
}

}  // namespace

TEST_CASE("a sample is the same number on every machine", "[sweep]") {
    // Written down once; a change of one of them changes everybody's sweeps.
    CHECK(sample_text(between(DistributionKind::uniform, 0, 1), 7, "key", 0) == "0.9214347038404594");
    CHECK(sample_text(between(DistributionKind::log_uniform, 1e-6, 1e-3), 7, "key", 1) ==
          "3.548200279876771e-05");
    Distribution normal;
    normal.kind = DistributionKind::normal;
    normal.mean = 5;
    CHECK(sample_text(normal, 7, "key", 2) == "4.515905144519212");
    CHECK(sample_text(between(DistributionKind::integer, 1, 100), 7, "key", 3) == "83");
}

TEST_CASE("samples depend on seed, key and number, and on nothing else", "[sweep]") {
    std::set<double> seen;
    for (const char* key : {"a", "b"})
        for (std::uint64_t seed : {0, 1})
            for (int k = 0; k < 1000; ++k) {
                const double u = unit_sample(seed, key, k, 0);
                CHECK((u > 0 && u < 1));
                seen.insert(u);
            }
    CHECK(seen.size() == 4000);
}

TEST_CASE("the normal quantile inverts the normal distribution function", "[sweep]") {
    for (double p = 1e-16; p < 0.5; p *= 1.7) {
        const double x = normal_quantile(p);
        CHECK(0.5 * std::erfc(-x / std::sqrt(2.0)) == Approx(p).epsilon(1e-13));
        if (p > 1e-3) CHECK(normal_quantile(1 - p) == Approx(-x).epsilon(1e-11));
    }
    CHECK(normal_quantile(0.5) == 0);
}

TEST_CASE("samples are distributed as they say", "[sweep]") {
    constexpr int n = 20000;
    SECTION("uniform and log-uniform") {
        // The distribution function at every sample, against the share of those below it: Kolmogorov's
        // statistic passes 1.95 / sqrt(n) once in a thousand seeds.
        for (const bool logarithmic : {false, true}) {
            std::vector<double> u;
            for (int k = 0; k < n; ++k) {
                const double x =
                    number(between(logarithmic ? DistributionKind::log_uniform : DistributionKind::uniform,
                                   1e-6, 1e-3),
                           k);
                u.push_back(logarithmic ? std::log(x / 1e-6) / std::log(1e3) : (x - 1e-6) / (1e-3 - 1e-6));
            }
            std::sort(u.begin(), u.end());
            double apart = 0;
            for (int k = 0; k < n; ++k) apart = std::max(apart, std::abs(u[k] - (k + 0.5) / n));
            CHECK(apart < 1.95 / std::sqrt(n));
        }
    }
    SECTION("normal, and cut off") {
        Distribution d;
        d.kind = DistributionKind::normal;
        d.mean = 3;
        d.deviation = 0.5;
        double sum = 0, squares = 0;
        for (int k = 0; k < n; ++k) {
            const double x = number(d, k) - 3;
            sum += x;
            squares += x * x;
        }
        CHECK(std::abs(sum / n) < 4 * 0.5 / std::sqrt(n));
        CHECK(std::sqrt(squares / n) == Approx(0.5).epsilon(0.02));
        d.low_said = true;
        d.low = 3.4;
        for (int k = 0; k < 500; ++k) CHECK(number(d, k) >= 3.4);
        d.low = 100;
        CHECK_THROWS_WITH(sample_text(d, 1, "k", 4), Catch::Contains("a thousand draws of sample 4"));
    }
    SECTION("integers and choices") {
        std::map<std::string, int> count;
        for (int k = 0; k < n; ++k)
            ++count[sample_text(between(DistributionKind::integer, -1, 2), 7, "key", k)];
        CHECK(count.size() == 4);
        for (const char* each : {"-1", "0", "1", "2"}) CHECK(std::abs(count[each] - n / 4) < 300);
        Distribution d;
        d.kind = DistributionKind::choice;
        d.choices = {"\"silk\"", "\"wool\"", "\"denim\""};
        d.weights = {1, 0, 3};
        count.clear();
        for (int k = 0; k < n; ++k) ++count[sample_text(d, 7, "key", k)];
        CHECK(count.size() == 2);
        CHECK(std::abs(count["\"silk\""] - n / 4) < 300);
    }
}
