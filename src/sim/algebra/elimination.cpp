#include "sim/algebra/elimination.h"

#include <algorithm>
#include <array>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace cloth {
namespace {

/// Whether a child may be padded with zeros to be merged with its parent: fewer, larger fronts are faster
/// than the flops that they save. `filled`: entries of L in both that are no padding. Padding of earlier
/// merges counts as what it is, or it would grow without bound along a narrow strip.
bool worth_merging(const Supernode& child, const Supernode& parent, double filled) {
    if (child.first + child.width != parent.first) return false;
    const double height = child.width + static_cast<double>(parent.rows.size());
    const double width = child.width + parent.width;
    const double zeros = width * height - 0.5 * width * (width - 1.0) - filled;
    if (width <= 4) return zeros <= 0.8 * filled;
    if (width <= 16) return zeros <= 0.3 * filled;
    return zeros <= 0.08 * filled;
}

}  // namespace

Elimination analyse(const BlockPattern& pattern, const std::vector<int>& pinned) {
    const int vertex_count = pattern.vertex_count();

    std::vector<int> free_index(vertex_count, -1), free_vertices;
    for (int v = 0; v < vertex_count; ++v) {
        if (std::binary_search(pinned.begin(), pinned.end(), v)) continue;
        free_index[v] = static_cast<int>(free_vertices.size());
        free_vertices.push_back(v);
    }
    const int n = static_cast<int>(free_vertices.size());
    Elimination result;
    result.position.assign(vertex_count, -1);
    if (n == 0) return result;

    // Fill-reducing order of the vertices.
    std::vector<Eigen::Triplet<double>> graph;
    for (int i = 0; i < vertex_count; ++i) {
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
    result.vertex_at.resize(n);
    for (int k = 0; k < n; ++k) {
        result.vertex_at[k] = free_vertices[order[k]];
        result.position[result.vertex_at[k]] = k;
    }

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
    std::vector<Supernode> found;
    std::vector<int>& node_of = result.supernode_of;
    node_of.resize(n);
    for (int j = 0; j < n; ++j) {
        const bool continues = j > 0 && parent[j - 1] == j && child_count[j] == 1 &&
                               structure[j - 1].size() == structure[j].size() + 1;
        if (!continues) {
            found.emplace_back();
            found.back().first = j;
            found.back().rows.push_back(j);
            found.back().rows.insert(found.back().rows.end(), structure[j].begin(), structure[j].end());
        }
        ++found.back().width;
        node_of[j] = static_cast<int>(found.size()) - 1;
    }
    // Merge a supernode into its parent where they are neighbours and little is padded. From the top down in
    // postorder the last child of a parent is the one that touches it.
    std::vector<bool> gone(found.size(), false);
    std::vector<double> filled;  // entries of L, shape (supernodes)
    for (const Supernode& node : found) {
        const auto width = static_cast<double>(node.width), height = static_cast<double>(node.rows.size());
        filled.push_back(width * height - 0.5 * width * (width - 1.0));
    }
    for (int s = static_cast<int>(found.size()) - 1; s >= 0; --s) {
        Supernode& child = found[s];
        if (static_cast<int>(child.rows.size()) == child.width) continue;
        const int p = node_of[child.rows[child.width]];
        Supernode& up = found[p];
        if (!worth_merging(child, up, filled[s] + filled[p])) continue;
        filled[p] += filled[s];
        std::vector<int> rows(child.rows.begin(), child.rows.begin() + child.width);
        rows.insert(rows.end(), up.rows.begin(), up.rows.end());
        up.first = child.first;
        up.width += child.width;
        up.rows.swap(rows);
        for (int j = child.first; j < child.first + child.width; ++j) node_of[j] = p;
        gone[s] = true;
    }
    std::vector<int> renumbered(found.size(), -1);
    for (std::size_t s = 0; s < found.size(); ++s) {
        if (gone[s]) continue;
        renumbered[s] = static_cast<int>(result.supernodes.size());
        result.supernodes.push_back(std::move(found[s]));
    }
    for (int& s : node_of) s = renumbered[s];
    return result;
}

}  // namespace cloth
