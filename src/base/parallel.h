#pragma once
// Loops over all cores whose results do not depend on the number of threads. Internal to the library.

#include <algorithm>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace cloth {

/// body(i) for each i in [0, count); iterations must not touch one another's data.
template <class Body>
void parallel_for(int count, const Body& body) {
    constexpr int grain = 128;
    if (count <= grain) {
        for (int i = 0; i < count; ++i) body(i);
        return;
    }
    tbb::parallel_for(tbb::blocked_range<int>(0, count, grain), [&](const tbb::blocked_range<int>& range) {
        for (int i = range.begin(); i < range.end(); ++i) body(i);
    });
}

/// Reduces value(i), i in [0, count), in a fixed order: within blocks of fixed length, then over the blocks.
template <class Value, class Combine>
double parallel_reduce(int count, double start, const Value& value, const Combine& combine) {
    constexpr int block = 256;
    std::vector<double> partial((count + block - 1) / block, start);
    tbb::parallel_for(0, static_cast<int>(partial.size()), [&](int b) {
        double sum = start;
        for (int i = b * block; i < std::min(count, (b + 1) * block); ++i) sum = combine(sum, value(i));
        partial[b] = sum;
    });
    double total = start;
    for (double p : partial) total = combine(total, p);
    return total;
}

template <class Value>
double parallel_sum(int count, const Value& value) {
    return parallel_reduce(count, 0.0, value, [](double a, double b) { return a + b; });
}

template <class Value>
double parallel_max(int count, double start, const Value& value) {
    return parallel_reduce(count, start, value, [](double a, double b) { return std::max(a, b); });
}

}  // namespace cloth
