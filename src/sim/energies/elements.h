#pragma once
// Elements of K vertices each, coloured so that no two of a colour share a vertex: a colour's elements can be
// added up by many threads at once, and each sum has the same order for any number of them. Internal.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "sim/algebra/block_matrix.h"
#include "sim/algebra/types.h"

namespace cloth {

template <int K>
class Elements {
  public:
    static constexpr int pair_count = K * (K + 1) / 2;
    using Stencil = std::array<int, K>;
    using Gradient = Eigen::Matrix<double, 3 * K, 1>;
    using Hessian = Eigen::Matrix<double, 3 * K, 3 * K>;

    explicit Elements(std::vector<Stencil> stencils) : stencils_(std::move(stencils)) { colour(); }

    int count() const { return static_cast<int>(stencils_.size()); }
    const Stencil& stencil(int e) const { return stencils_[e]; }

    Gradient gather(const VecX& x, int e) const {
        Gradient q;
        for (int i = 0; i < K; ++i) q.template segment<3>(3 * i) = x.segment<3>(3 * stencils_[e][i]);
        return q;
    }

    void append_pairs(std::vector<std::array<int, 2>>& pairs) const {
        for (const Stencil& s : stencils_) {
            for (int i = 0; i < K; ++i) {
                for (int j = i + 1; j < K; ++j) pairs.push_back({s[i], s[j]});
            }
        }
    }

    void bind(const BlockPattern& pattern) {
        slots_.resize(stencils_.size());
        for (std::size_t e = 0; e < stencils_.size(); ++e) {
            int p = 0;
            for (int i = 0; i < K; ++i) {
                for (int j = i; j < K; ++j) {
                    const int a = stencils_[e][i], b = stencils_[e][j];
                    // A negative number says that the element's block goes in transposed.
                    slots_[e][p++] = a <= b ? pattern.slot(a, b) : ~pattern.slot(b, a);
                }
            }
        }
    }

    /// gradient(e) → Gradient, added to g; the same of skip(e).
    template <class F>
    void add_gradient(VecX& g, const F& gradient) const {
        add_gradient(g, gradient, [](int) { return false; });
    }
    template <class F, class Skip>
    void add_gradient(VecX& g, const F& gradient, const Skip& skip) const {
        for_each([&](int e) {
            if (skip(e)) return;
            const Gradient ge = gradient(e);
            for (int i = 0; i < K; ++i) g.segment<3>(3 * stencils_[e][i]) += ge.template segment<3>(3 * i);
        });
    }

    /// hessian(e) → symmetric Hessian, added to H; of elements with skip(e) it is known to be 0.
    template <class F>
    void add_hessian(BlockMatrix& H, const F& hessian) const {
        add_hessian(H, hessian, [](int) { return false; });
    }
    template <class F, class Skip>
    void add_hessian(BlockMatrix& H, const F& hessian, const Skip& skip) const {
        for_each([&](int e) {
            if (skip(e)) return;
            const Hessian He = hessian(e);
            int p = 0;
            for (int i = 0; i < K; ++i) {
                for (int j = i; j < K; ++j) {
                    const int slot = slots_[e][p++];
                    if (slot >= 0) {
                        H.blocks[slot] += He.template block<3, 3>(3 * i, 3 * j);
                    } else {
                        H.blocks[~slot] += He.template block<3, 3>(3 * i, 3 * j).transpose();
                    }
                }
            }
        });
    }

    template <class F>
    double sum(const F& value) const {
        return parallel_sum(count(), value);
    }

  private:
    template <class F>
    void for_each(const F& body) const {
        for (std::size_t c = 0; c + 1 < colour_begin_.size(); ++c) {
            const int begin = colour_begin_[c];
            parallel_for(colour_begin_[c + 1] - begin, [&](int i) { body(order_[begin + i]); });
        }
    }

    /// Greedy, in element order; up to 64 colours by bit mask, which no cloth mesh of sane valence exceeds.
    /// What is left over gets a colour each.
    void colour() {
        int vertices = 0;
        for (const Stencil& s : stencils_) {
            for (int v : s) vertices = std::max(vertices, v + 1);
        }
        std::vector<std::uint64_t> used(vertices, 0);
        std::vector<std::vector<int>> colours(64);
        std::vector<int> rest;
        for (int e = 0; e < count(); ++e) {
            std::uint64_t taken = 0;
            for (int v : stencils_[e]) taken |= used[v];
            if (~taken == 0) {
                rest.push_back(e);
                continue;
            }
            const int c = std::countr_one(taken);
            for (int v : stencils_[e]) used[v] |= std::uint64_t{1} << c;
            colours[c].push_back(e);
        }
        for (int e : rest) colours.push_back({e});
        for (const auto& c : colours) {
            if (c.empty()) continue;
            order_.insert(order_.end(), c.begin(), c.end());
            colour_begin_.push_back(static_cast<int>(order_.size()));
        }
    }

    std::vector<Stencil> stencils_;
    std::vector<std::array<int, pair_count>> slots_;
    std::vector<int> order_;
    std::vector<int> colour_begin_{0};
};

}  // namespace cloth
