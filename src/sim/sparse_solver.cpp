#include "sim/sparse_solver.h"

#include <algorithm>
#include <atomic>

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>
#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace cloth {
namespace {

/// Consecutive columns (vertices, in elimination order) with the same structure below them.
struct Supernode {
    int first = 0, width = 0;  ///< columns first … first + width - 1
    std::vector<int> rows;     ///< the columns themselves, then the rows below, ascending
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
    Eigen::MatrixXd factor;            ///< 3 rows × 3 width: L in these columns
    Eigen::MatrixXd update;            ///< Schur complement handed to the parent, lower triangle
    long subtree_work = 0;             ///< rough flops below and here, to decide what is worth a task
};

/// Columns of a supernode may be padded with zeros up to this share to merge it with its parent: fewer,
/// larger fronts are faster than the flops that they save.
bool worth_merging(const Supernode& child, const Supernode& parent) {
    if (child.first + child.width != parent.first) return false;
    const double rows_merged = child.width + static_cast<double>(parent.rows.size());
    const double width_merged = child.width + parent.width;
    const double before = static_cast<double>(child.width) * static_cast<double>(child.rows.size()) +
                          static_cast<double>(parent.width) * static_cast<double>(parent.rows.size());
    const double zeros = width_merged * rows_merged - before - 0.5 * child.width * parent.width;
    if (width_merged <= 4) return zeros <= 0.8 * before;
    if (width_merged <= 16) return zeros <= 0.3 * before;
    return zeros <= 0.08 * before;
}

}  // namespace

struct SparseSolver::Impl {
    int vertex_count = 0;
    std::vector<int> vertex_at;  ///< elimination order → vertex
    std::vector<Supernode> nodes;
    std::vector<int> roots;
    std::atomic<bool> failed{false};

    void factorize_subtree(int s, const BlockMatrix& A);
    void factorize_front(int s, const BlockMatrix& A);
};

SparseSolver::SparseSolver(const BlockPattern& pattern, const std::vector<int>& pinned)
    : impl_(std::make_unique<Impl>()) {
    Impl& d = *impl_;
    d.vertex_count = pattern.vertex_count();

    std::vector<int> free_index(d.vertex_count, -1), free_vertices;
    for (int v = 0; v < d.vertex_count; ++v) {
        if (std::binary_search(pinned.begin(), pinned.end(), v)) continue;
        free_index[v] = static_cast<int>(free_vertices.size());
        free_vertices.push_back(v);
    }
    const int n = static_cast<int>(free_vertices.size());
    if (n == 0) return;

    // Fill-reducing order of the vertices.
    std::vector<Eigen::Triplet<double>> graph;
    for (int i = 0; i < d.vertex_count; ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            const int a = free_index[i], b = free_index[pattern.column[s]];
            if (a < 0 || b < 0) continue;
            graph.emplace_back(a, b, 1.0);
            if (a != b) graph.emplace_back(b, a, 1.0);
        }
    }
    Eigen::SparseMatrix<double> adjacency(n, n);
    adjacency.setFromTriplets(graph.begin(), graph.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> amd;
    Eigen::AMDOrdering<int>()(adjacency, amd);
    std::vector<int> order(n);  // position → free index
    for (int k = 0; k < n; ++k) order[k] = amd.indices()(k);

    // Elimination tree and its postorder, so that a supernode's columns are neighbours.
    auto elimination_tree = [&](const std::vector<int>& position) {
        std::vector<int> parent(n, -1), ancestor(n, -1);
        std::vector<int> at(n);
        for (int f = 0; f < n; ++f) at[position[f]] = f;
        for (int j = 0; j < n; ++j) {
            for (Eigen::SparseMatrix<double>::InnerIterator it(adjacency, at[j]); it; ++it) {
                int i = position[it.row()];
                while (i != -1 && i < j) {
                    const int next = ancestor[i];
                    ancestor[i] = j;
                    if (next == -1) parent[i] = j;
                    i = next;
                }
            }
        }
        return parent;
    };
    std::vector<int> position(n);
    for (int k = 0; k < n; ++k) position[order[k]] = k;
    std::vector<int> parent = elimination_tree(position);
    {
        std::vector<std::vector<int>> children(n);
        std::vector<int> stack, postorder;
        for (int j = n - 1; j >= 0; --j) (parent[j] < 0 ? stack : children[parent[j]]).push_back(j);
        std::vector<std::size_t> next(n, 0);
        // Children were pushed in descending order; taking them from the back keeps the order ascending.
        std::vector<int> path;
        while (!stack.empty()) {
            path.push_back(stack.back());
            stack.pop_back();
            while (!path.empty()) {
                const int j = path.back();
                if (next[j] < children[j].size()) {
                    path.push_back(children[j][children[j].size() - 1 - next[j]++]);
                } else {
                    postorder.push_back(j);
                    path.pop_back();
                }
            }
        }
        std::vector<int> reordered(n);
        for (int k = 0; k < n; ++k) reordered[k] = order[postorder[k]];
        order = reordered;
    }
    for (int k = 0; k < n; ++k) position[order[k]] = k;
    parent = elimination_tree(position);
    d.vertex_at.resize(n);
    for (int k = 0; k < n; ++k) d.vertex_at[k] = free_vertices[order[k]];

    // Column structures of L, bottom up; fundamental supernodes: a chain whose structure loses just its own
    // column.
    std::vector<std::vector<int>> structure(n);
    std::vector<int> child_count(n, 0);
    for (int j = 0; j < n; ++j) {
        std::vector<int>& rows = structure[j];
        for (Eigen::SparseMatrix<double>::InnerIterator it(adjacency, order[j]); it; ++it) {
            if (position[it.row()] > j) rows.push_back(position[it.row()]);
        }
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        structure[j] = rows;
        if (parent[j] >= 0) ++child_count[parent[j]];
    }
    for (int j = 0; j < n; ++j) {
        if (parent[j] < 0) continue;
        std::vector<int>& up = structure[parent[j]];
        std::vector<int> merged;
        std::set_union(up.begin(), up.end(), structure[j].begin() + 1, structure[j].end(),
                       std::back_inserter(merged));
        up.swap(merged);
    }
    std::vector<Supernode> nodes;
    std::vector<int> node_of(n);
    for (int j = 0; j < n; ++j) {
        const bool continues = j > 0 && parent[j - 1] == j && child_count[j] == 1 &&
                               structure[j - 1].size() == structure[j].size() + 1;
        if (!continues) {
            nodes.emplace_back();
            nodes.back().first = j;
            nodes.back().rows.push_back(j);
            nodes.back().rows.insert(nodes.back().rows.end(), structure[j].begin(), structure[j].end());
        }
        ++nodes.back().width;
        node_of[j] = static_cast<int>(nodes.size()) - 1;
    }
    // Merge a supernode into its parent where they are neighbours and little is padded. From the top down in
    // postorder the last child of a parent is the one that touches it.
    std::vector<bool> gone(nodes.size(), false);
    for (int s = static_cast<int>(nodes.size()) - 1; s >= 0; --s) {
        Supernode& child = nodes[s];
        if (static_cast<int>(child.rows.size()) == child.width) continue;
        const int p = node_of[child.rows[child.width]];
        Supernode& up = nodes[p];
        if (!worth_merging(child, up)) continue;
        std::vector<int> rows(child.rows.begin(), child.rows.begin() + child.width);
        rows.insert(rows.end(), up.rows.begin(), up.rows.end());
        up.first = child.first;
        up.width += child.width;
        up.rows.swap(rows);
        for (int j = child.first; j < child.first + child.width; ++j) node_of[j] = p;
        gone[s] = true;
    }
    std::vector<int> renumbered(nodes.size(), -1);
    for (std::size_t s = 0; s < nodes.size(); ++s) {
        if (gone[s]) continue;
        renumbered[s] = static_cast<int>(d.nodes.size());
        d.nodes.push_back(std::move(nodes[s]));
    }
    for (int& s : node_of) s = renumbered[s];

    for (std::size_t s = 0; s < d.nodes.size(); ++s) {
        Supernode& node = d.nodes[s];
        const auto height = static_cast<long>(node.rows.size());
        node.factor.resize(3 * height, 3 * node.width);
        node.subtree_work += node.width * height * height;
        if (height == node.width) {
            d.roots.push_back(static_cast<int>(s));
            continue;
        }
        node.parent = node_of[node.rows[node.width]];
        Supernode& up = d.nodes[node.parent];
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
            const int a = free_index[i], b = free_index[pattern.column[slot]];
            if (a < 0 || b < 0) continue;
            const int row = position[a], column = position[b];  // the stored block is (row, column)
            const bool transposed = row < column;
            const int low = std::min(row, column), high = std::max(row, column);
            Supernode& node = d.nodes[node_of[low]];
            const int front_row = static_cast<int>(
                std::lower_bound(node.rows.begin(), node.rows.end(), high) - node.rows.begin());
            node.entries.push_back({front_row, low - node.first, slot, transposed});
        }
    }
}

SparseSolver::~SparseSolver() = default;
SparseSolver::SparseSolver(SparseSolver&&) noexcept = default;
SparseSolver& SparseSolver::operator=(SparseSolver&&) noexcept = default;

void SparseSolver::Impl::factorize_front(int s, const BlockMatrix& A) {
    Supernode& node = nodes[s];
    Eigen::MatrixXd& L = node.factor;
    Eigen::MatrixXd& U = node.update;
    const int width = 3 * node.width;
    const auto below = static_cast<int>(node.place_in_parent.size()) * 3;
    L.setZero();
    U.setZero();
    for (const Supernode::Entry& e : node.entries) {
        if (e.transposed) {
            L.block<3, 3>(3 * e.row, 3 * e.column) = A.blocks[e.slot].transpose();
        } else {
            L.block<3, 3>(3 * e.row, 3 * e.column) = A.blocks[e.slot];
        }
    }
    for (int c : node.children) {
        const Supernode& child = nodes[c];
        const auto& place = child.place_in_parent;
        for (std::size_t j = 0; j < place.size(); ++j) {
            const auto column = static_cast<Eigen::Index>(3 * j);
            for (std::size_t i = j; i < place.size(); ++i) {
                const auto row = static_cast<Eigen::Index>(3 * i);
                if (place[j] < node.width) {
                    L.block<3, 3>(3 * place[i], 3 * place[j]) += child.update.block<3, 3>(row, column);
                } else {
                    U.block<3, 3>(3 * (place[i] - node.width), 3 * (place[j] - node.width)) +=
                        child.update.block<3, 3>(row, column);
                }
            }
        }
    }
    auto top = L.topRows(width);
    Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(top);
    // Eigen lets a NaN pivot pass.
    if (llt.info() != Eigen::Success || !top.diagonal().allFinite()) {
        failed = true;
        return;
    }
    if (below > 0) {
        auto bottom = L.bottomRows(below);
        top.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(bottom);
        U.selfadjointView<Eigen::Lower>().rankUpdate(bottom, -1.0);
    }
}

void SparseSolver::Impl::factorize_subtree(int s, const BlockMatrix& A) {
    const Supernode& node = nodes[s];
    constexpr long worth_a_task = 20000;
    std::vector<int> large, small;
    for (int c : node.children) (nodes[c].subtree_work > worth_a_task ? large : small).push_back(c);
    if (large.size() > 1) {
        tbb::task_group group;
        for (int c : large) group.run([this, c, &A] { factorize_subtree(c, A); });
        group.wait();
    } else {
        for (int c : large) factorize_subtree(c, A);
    }
    for (int c : small) factorize_subtree(c, A);
    if (!failed) factorize_front(s, A);
}

bool SparseSolver::factorize(const BlockMatrix& A) {
    Impl& d = *impl_;
    d.failed = false;
    for (int root : d.roots) {
        if (!d.failed) d.factorize_subtree(root, A);
    }
    return !d.failed;
}

void SparseSolver::solve(const VecX& b, VecX& x) const {
    const Impl& d = *impl_;
    const auto n = static_cast<int>(d.vertex_at.size());
    VecX y(3 * n), part;
    for (int k = 0; k < n; ++k) y.segment<3>(3 * k) = b.segment<3>(3 * d.vertex_at[k]);
    for (const Supernode& node : d.nodes) {
        const int width = 3 * node.width;
        auto top = y.segment(3 * node.first, width);
        node.factor.topRows(width).triangularView<Eigen::Lower>().solveInPlace(top);
        if (node.parent < 0) continue;
        part.noalias() = node.factor.bottomRows(node.factor.rows() - width) * top;
        for (std::size_t r = node.width; r < node.rows.size(); ++r) {
            y.segment<3>(3 * node.rows[r]) -=
                part.segment<3>(static_cast<Eigen::Index>(3 * (r - node.width)));
        }
    }
    for (auto node = d.nodes.rbegin(); node != d.nodes.rend(); ++node) {
        const int width = 3 * node->width;
        auto top = y.segment(3 * node->first, width);
        if (node->parent >= 0) {
            part.resize(node->factor.rows() - width);
            for (std::size_t r = node->width; r < node->rows.size(); ++r) {
                part.segment<3>(static_cast<Eigen::Index>(3 * (r - node->width))) =
                    y.segment<3>(3 * node->rows[r]);
            }
            top.noalias() -= node->factor.bottomRows(node->factor.rows() - width).transpose() * part;
        }
        node->factor.topRows(width).triangularView<Eigen::Lower>().transpose().solveInPlace(top);
    }
    x.setZero(3 * d.vertex_count);
    for (int k = 0; k < n; ++k) x.segment<3>(3 * d.vertex_at[k]) = y.segment<3>(3 * k);
}

}  // namespace cloth
