#include "sim/algebra/sparse_solver.h"

#include <algorithm>
#include <atomic>
#include <type_traits>

#include <Eigen/Cholesky>

#include "base/parallel.h"
#include "sim/algebra/elimination.h"
#include "sim/algebra/fixed_blocking.h"
#include "sim/algebra/flush_to_zero.h"

namespace cloth {
namespace {

/// A supernode with its numbers.
template <class Scalar>
struct Front : Supernode {
    using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
    int parent = -1;
    std::vector<int> children;
    /// A's blocks in these columns: front row and column (in vertices), source slot, and whether it is
    /// transposed.
    struct Entry {
        int row, column, slot;
        bool transposed;
    };
    std::vector<Entry> entries;
    std::vector<int> place_in_parent;  ///< of each row below: index into the parent's rows
    Matrix factor;                     ///< 3 rows × 3 width: L in these columns
    Matrix update;                     ///< Schur complement handed to the parent, lower triangle
    /// While solving: the right-hand side's part on `rows`, then what this subtree takes from the rows below.
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> part;
    long subtree_work = 0;  ///< rough flops below and here, to decide what is worth a task
};

/// A front with this many rows below its columns is worth several threads, which take `piece` rows each:
/// pieces of fixed size, whose sums are the same on any number.
constexpr int piece = 120;
constexpr int worth_threads = 3 * piece;

/// How the numbers of a front are reckoned with. Entries of L fall off with the distance of their vertices:
/// in single precision many of a wide sheet's are denormal, and a factorization of 100 x 100 vertices
/// took 2.5 times as long.
struct AsTheyAre {};
template <class Scalar>
using Arithmetic = std::conditional_t<std::is_same_v<Scalar, float>, FlushToZero, AsTheyAre>;

}  // namespace

struct SparseSolver::Impl {
    virtual ~Impl() = default;
    Statistics statistics;
    virtual bool factorize(const BlockMatrix& A) = 0;
    virtual void solve(const VecX& b, VecX& x) = 0;
};

namespace {

template <class Scalar>
struct Multifrontal final : SparseSolver::Impl {
    using Node = Front<Scalar>;
    using Matrix = typename Node::Matrix;

    int vertex_count = 0;
    std::vector<int> vertex_at;  ///< elimination order → vertex
    std::vector<Node> nodes;
    std::vector<int> roots;
    std::atomic<bool> failed{false};
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> y;  ///< while solving, in elimination order

    Multifrontal(const BlockPattern& pattern, const std::vector<int>& pinned);
    bool factorize(const BlockMatrix& A) override;
    void solve(const VecX& b, VecX& x) override;

    void count(const Node& node);
    void factorize_front(int s, const BlockMatrix& A);
    void forward(int s);
    void backward(int s);
    /// visit(s) for s and all below it, children before parents or the other way round; large subtrees on
    /// different threads.
    template <class F>
    void up_tree(int s, const F& visit);
    template <class F>
    void down_tree(int s, const F& visit);
    template <class F>
    void for_children(int s, const F& visit);
};

template <class Scalar>
Multifrontal<Scalar>::Multifrontal(const BlockPattern& pattern, const std::vector<int>& pinned) {
    Multifrontal& d = *this;
    Elimination found = analyse(pattern, pinned);
    d.vertex_count = pattern.vertex_count();
    d.vertex_at = std::move(found.vertex_at);
    for (Supernode& each : found.supernodes)
        static_cast<Supernode&>(d.nodes.emplace_back()) = std::move(each);
    const std::vector<int>& node_of = found.supernode_of;
    for (std::size_t s = 0; s < d.nodes.size(); ++s) {
        Node& node = d.nodes[s];
        const auto height = static_cast<long>(node.rows.size());
        node.factor.resize(3 * height, 3 * node.width);
        node.subtree_work += node.width * height * height;
        d.count(node);
        if (height == node.width) {
            d.roots.push_back(static_cast<int>(s));
            continue;
        }
        node.parent = node_of[node.rows[node.width]];
        Node& up = d.nodes[node.parent];
        up.children.push_back(static_cast<int>(s));
        up.subtree_work += node.subtree_work;
        for (std::size_t r = node.width; r < node.rows.size(); ++r) {
            node.place_in_parent.push_back(static_cast<int>(
                std::lower_bound(up.rows.begin(), up.rows.end(), node.rows[r]) - up.rows.begin()));
        }
        node.update.resize(3 * (height - node.width), 3 * (height - node.width));
    }
    for (int i = 0; i < d.vertex_count; ++i) {
        for (int slot = pattern.row_begin[i]; slot < pattern.row_begin[i + 1]; ++slot) {
            // The stored block is (row, column).
            const int row = found.position[i], column = found.position[pattern.column[slot]];
            if (row < 0 || column < 0) continue;
            const bool transposed = row < column;
            const int low = std::min(row, column), high = std::max(row, column);
            Node& node = d.nodes[node_of[low]];
            const int front_row = static_cast<int>(
                std::lower_bound(node.rows.begin(), node.rows.end(), high) - node.rows.begin());
            node.entries.push_back({front_row, low - node.first, slot, transposed});
        }
    }
}

template <class Scalar>
void Multifrontal<Scalar>::count(const Node& node) {
    const auto rows = static_cast<int>(3 * node.rows.size());
    ++statistics.fronts;
    statistics.parallel_fronts += rows - 3 * node.width >= worth_threads;
    statistics.greatest_front = std::max(statistics.greatest_front, rows);
    for (int column = 0; column < 3 * node.width; ++column) {
        const double entries = rows - column;
        statistics.entries += entries;
        statistics.flops += entries * entries;
    }
}

template <class Scalar>
void Multifrontal<Scalar>::factorize_front(int s, const BlockMatrix& A) {
    [[maybe_unused]] const Arithmetic<Scalar> arithmetic;
    Node& node = nodes[s];
    Matrix& L = node.factor;
    Matrix& U = node.update;
    const int width = 3 * node.width;
    const auto below = static_cast<int>(node.place_in_parent.size()) * 3;
    L.setZero();
    U.setZero();
    for (const auto& e : node.entries) {
        auto target = L.template block<3, 3>(3 * e.row, 3 * e.column);
        if (e.transposed) {
            target = A.blocks[e.slot].transpose().template cast<Scalar>();
        } else {
            target = A.blocks[e.slot].template cast<Scalar>();
        }
    }
    for (int c : node.children) {
        const Node& child = nodes[c];
        const auto& place = child.place_in_parent;
        for (std::size_t j = 0; j < place.size(); ++j) {
            const auto column = static_cast<Eigen::Index>(3 * j);
            for (std::size_t i = j; i < place.size(); ++i) {
                const auto row = static_cast<Eigen::Index>(3 * i);
                const auto from = child.update.template block<3, 3>(row, column);
                if (place[j] < node.width) {
                    L.template block<3, 3>(3 * place[i], 3 * place[j]) += from;
                } else {
                    U.template block<3, 3>(3 * (place[i] - node.width), 3 * (place[j] - node.width)) += from;
                }
            }
        }
    }
    auto top = L.topRows(width);
    Eigen::LLT<Eigen::Ref<Matrix>> llt(top);
    // Eigen lets a NaN pivot pass.
    if (llt.info() != Eigen::Success || !top.diagonal().allFinite()) {
        failed = true;
        return;
    }
    if (below == 0) return;
    auto bottom = L.bottomRows(below);
    if (below < worth_threads) {
        top.template triangularView<Eigen::Lower>().transpose().template solveInPlace<Eigen::OnTheRight>(
            bottom);
        U.template selfadjointView<Eigen::Lower>().rankUpdate(bottom, Scalar(-1));
        return;
    }
    const int pieces = (below + piece - 1) / piece;
    parallel_tasks(pieces, [&](int p) {
        [[maybe_unused]] const Arithmetic<Scalar> of_this_thread;
        auto rows = bottom.middleRows(p * piece, std::min(piece, below - p * piece));
        top.template triangularView<Eigen::Lower>().transpose().template solveInPlace<Eigen::OnTheRight>(
            rows);
    });
    parallel_tasks(pieces, [&](int p) {
        [[maybe_unused]] const Arithmetic<Scalar> of_this_thread;
        const int first = p * piece, size = std::min(piece, below - first), rest = below - first - size;
        const auto rows = bottom.middleRows(first, size);
        U.block(first, first, size, size)
            .template selfadjointView<Eigen::Lower>()
            .rankUpdate(rows, Scalar(-1));
        if (rest > 0) {
            U.block(first + size, first, rest, size).noalias() -= bottom.bottomRows(rest) * rows.transpose();
        }
    });
}

template <class Scalar>
template <class F>
void Multifrontal<Scalar>::for_children(int s, const F& visit) {
    constexpr long worth_a_task = 20000;
    std::vector<int> large;
    for (int c : nodes[s].children) {
        if (nodes[c].subtree_work > worth_a_task) large.push_back(c);
    }
    if (large.size() > 1) {
        parallel_tasks(static_cast<int>(large.size()), [&](int i) { visit(large[i]); });
    } else {
        for (int c : large) visit(c);
    }
    for (int c : nodes[s].children) {
        if (nodes[c].subtree_work <= worth_a_task) visit(c);
    }
}

template <class Scalar>
template <class F>
void Multifrontal<Scalar>::up_tree(int s, const F& visit) {
    for_children(s, [&](int c) { up_tree(c, visit); });
    visit(s);
}

template <class Scalar>
template <class F>
void Multifrontal<Scalar>::down_tree(int s, const F& visit) {
    visit(s);
    for_children(s, [&](int c) { down_tree(c, visit); });
}

template <class Scalar>
bool Multifrontal<Scalar>::factorize(const BlockMatrix& A) {
    failed = false;
    for (int root : roots) {
        if (!failed) {
            up_tree(root, [&](int s) {
                if (!failed) factorize_front(s, A);
            });
        }
    }
    return !failed;
}

template <class Scalar>
void Multifrontal<Scalar>::forward(int s) {
    [[maybe_unused]] const Arithmetic<Scalar> arithmetic;
    Node& node = nodes[s];
    const int width = 3 * node.width;
    auto& part = node.part;
    part.setZero(node.factor.rows());
    part.head(width) = y.segment(3 * node.first, width);
    for (int c : node.children) {
        const Node& child = nodes[c];
        for (std::size_t r = 0; r < child.place_in_parent.size(); ++r) {
            part.template segment<3>(3 * child.place_in_parent[r]) +=
                child.part.template segment<3>(static_cast<Eigen::Index>(3 * (child.width + r)));
        }
    }
    auto top = part.head(width);
    node.factor.topRows(width).template triangularView<Eigen::Lower>().solveInPlace(top);
    y.segment(3 * node.first, width) = top;
    if (node.parent < 0) return;
    const Eigen::Index below = node.factor.rows() - width;
    part.tail(below).noalias() -= node.factor.bottomRows(below) * top;
}

template <class Scalar>
void Multifrontal<Scalar>::backward(int s) {
    [[maybe_unused]] const Arithmetic<Scalar> arithmetic;
    Node& node = nodes[s];
    const int width = 3 * node.width;
    auto top = y.segment(3 * node.first, width);
    if (node.parent >= 0) {
        const Eigen::Index below = node.factor.rows() - width;
        auto part = node.part.tail(below);
        for (std::size_t r = node.width; r < node.rows.size(); ++r) {
            part.template segment<3>(static_cast<Eigen::Index>(3 * (r - node.width))) =
                y.template segment<3>(3 * node.rows[r]);
        }
        top.noalias() -= node.factor.bottomRows(below).transpose() * part;
    }
    node.factor.topRows(width).template triangularView<Eigen::Lower>().transpose().solveInPlace(top);
}

template <class Scalar>
void Multifrontal<Scalar>::solve(const VecX& b, VecX& x) {
    const auto n = static_cast<int>(vertex_at.size());
    y.resize(3 * n);
    for (int k = 0; k < n; ++k) {
        y.template segment<3>(3 * k) = b.segment<3>(3 * vertex_at[k]).template cast<Scalar>();
    }
    for (int root : roots) up_tree(root, [&](int s) { forward(s); });
    for (int root : roots) down_tree(root, [&](int s) { backward(s); });
    x.setZero(3 * vertex_count);
    for (int k = 0; k < n; ++k) {
        x.segment<3>(3 * vertex_at[k]) = y.template segment<3>(3 * k).template cast<double>();
    }
}

}  // namespace

SparseSolver::SparseSolver(const BlockPattern& pattern, const std::vector<int>& pinned, Precision precision) {
    fix_blocking();
    if (precision == Precision::full) {
        impl_ = std::make_unique<Multifrontal<double>>(pattern, pinned);
    } else {
        impl_ = std::make_unique<Multifrontal<float>>(pattern, pinned);
    }
}

SparseSolver::~SparseSolver() = default;
SparseSolver::SparseSolver(SparseSolver&&) noexcept = default;
SparseSolver& SparseSolver::operator=(SparseSolver&&) noexcept = default;

bool SparseSolver::factorize(const BlockMatrix& A) {
    return impl_->factorize(A);
}

const SparseSolver::Statistics& SparseSolver::statistics() const {
    return impl_->statistics;
}

void SparseSolver::solve(const VecX& b, VecX& x) const {
    impl_->solve(b, x);
}

}  // namespace cloth
