#pragma once
// Loops over all cores whose results do not depend on the number of threads. Internal to the library.

#include <algorithm>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CLOTH_PLAIN_THREADS 1
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define CLOTH_PLAIN_THREADS 1
#endif
#if defined(CLOTH_PLAIN_THREADS)
#include <atomic>
#include <thread>
#endif

namespace cloth {

/// task(i) for each i in [0, count), each worth a thread's while; tasks must not touch one another's data.
template <class Task>
void parallel_tasks(int count, const Task& task) {
#if defined(CLOTH_PLAIN_THREADS)
    // The thread sanitizer cannot see into oneTBB, whose library is built without it.
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) task(i);
    };
    std::thread other(work);
    work();
    other.join();
#else
    tbb::parallel_for(0, count, task);
#endif
}

/// body(i) for each i in [0, count); iterations must not touch one another's data.
template <class Body>
void parallel_for(int count, const Body& body) {
    constexpr int grain = 128;
    if (count <= grain) {
        for (int i = 0; i < count; ++i) body(i);
        return;
    }
#if defined(CLOTH_PLAIN_THREADS)
    parallel_tasks((count + grain - 1) / grain, [&](int b) {
        for (int i = b * grain; i < std::min(count, (b + 1) * grain); ++i) body(i);
    });
#else
    tbb::parallel_for(tbb::blocked_range<int>(0, count, grain), [&](const tbb::blocked_range<int>& range) {
        for (int i = range.begin(); i < range.end(); ++i) body(i);
    });
#endif
}

/// Reduces value(i), i in [0, count), in a fixed order: within blocks of fixed length, then over the blocks.
template <class Value, class Combine>
double parallel_reduce(int count, double start, const Value& value, const Combine& combine) {
    constexpr int block = 256;
    std::vector<double> partial((count + block - 1) / block, start);
    parallel_tasks(static_cast<int>(partial.size()), [&](int b) {
        double sum = start;
        for (int i = b * block; i < std::min(count, (b + 1) * block); ++i) sum = combine(sum, value(i));
        partial[b] = sum;
    });
    double total = start;
    for (double p : partial) total = combine(total, p);
    return total;
}

/// What find(i, out), i in [0, count), appends to `out`, in the order of i.
template <class T, class Find>
std::vector<T> parallel_collect(int count, const Find& find) {
    constexpr int block = 512;
    std::vector<std::vector<T>> parts((count + block - 1) / block);
    parallel_tasks(static_cast<int>(parts.size()), [&](int b) {
        for (int i = b * block; i < std::min(count, (b + 1) * block); ++i) find(i, parts[b]);
    });
    std::vector<T> all;
    for (const std::vector<T>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
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
