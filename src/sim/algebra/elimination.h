#pragma once
// The symbolic half of a Cholesky factorization: order, elimination tree and supernodes, found on the graph
// of vertices (3x3 blocks). (Davis 2006, Direct Methods for Sparse Linear Systems, chapters 4 and 7.)

#include <vector>

#include "sim/algebra/block_matrix.h"

namespace cloth {

/// Consecutive columns (vertices, in elimination order) with the same structure below them.
struct Supernode {
    int first = 0, width = 0;  ///< columns first … first + width - 1
    std::vector<int> rows;     ///< the columns themselves, then the rows below, ascending
};

struct Elimination {
    std::vector<int> vertex_at;         ///< elimination order → vertex
    std::vector<int> position;          ///< vertex → elimination order; -1: pinned
    std::vector<Supernode> supernodes;  ///< in postorder: children before parents
    std::vector<int> supernode_of;      ///< elimination order → supernode
};

/// By approximate minimum degree. `pinned`: sorted vertices whose rows and columns are left out.
Elimination analyse(const BlockPattern& pattern, const std::vector<int>& pinned);

}  // namespace cloth
