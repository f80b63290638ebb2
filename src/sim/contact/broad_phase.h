#pragma once
// Which pairs may touch: a tree of boxes over each body's simplices. The trees' shapes are built once, from
// rest positions, where neighbours in the cloth are neighbours in space for the whole run; the boxes are
// fitted to each question. Of two lists, what both contain stands in the same order.

#include <array>
#include <compare>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/geometry/box_tree.h"
#include "sim/geometry/collide.h"

namespace cloth {

/// Of points that go straight ways in the same time: where they are at the start and at the end. In between,
/// the box lies within that of the interpolated bounds.
struct MovingBox {
    Box start, end;

    void add(const MovingBox& b) {
        start.add(b.start);
        end.add(b.end);
    }
    void inflate(double r) {
        start.inflate(r);
        end.inflate(r);
    }
};
/// False where an axis keeps the two apart at the start and, the same way round, at the end: then it does so
/// at every time between.
inline bool may_meet(const MovingBox& a, const MovingBox& b) {
    for (int k = 0; k < 3; ++k) {
        if (a.start.low(k) > b.start.high(k) && a.end.low(k) > b.end.high(k)) return false;
        if (b.start.low(k) > a.start.high(k) && b.end.low(k) > a.end.high(k)) return false;
    }
    return true;
}

/// Triangles, edges and single points that may touch; one per connected thing (a sheet, a collider).
struct ContactBody {
    bool collider = false;  ///< moves as prescribed; colliders do not meet each other
    int index = 0;          ///< into the scene's cloths or colliders
    double radius = 0.0;    ///< the surface stands this far out from the simplices [m]
};

/// All that contact sees, cloth first: vertex v of the cloths keeps its number.
struct ContactMesh {
    std::vector<ContactBody> bodies;
    std::vector<int> vertex_body;
    std::vector<int> vertex_piece;  ///< connected by edges, across no body: the first vertex of the piece
    std::vector<std::array<int, 2>> edges;
    std::vector<std::array<int, 3>> faces;
    std::vector<int> lone_points;  ///< vertices of no edge
    std::vector<int> lone_edges;   ///< numbers of edges of no face

    int vertex_count() const { return static_cast<int>(vertex_body.size()); }
    /// Adds a body; its vertices get the next numbers. Edges of the triangles are found, each once.
    void add_body(const ContactBody& body, int vertices, const std::vector<std::array<int, 3>>& triangles,
                  const std::vector<std::array<int, 2>>& segments = {});
};

/// Points of the pair, in the order that collide.h gives them.
struct PairCandidate {
    PairKind kind;
    int a, b;  ///< vertex and face, or two edges, a < b

    friend auto operator<=>(const PairCandidate&, const PairCandidate&) = default;
};
std::array<int, 4> pair_points(const ContactMesh& mesh, const PairCandidate& pair);

class BroadPhase {
  public:
    /// `positions`, shape (3 · vertices), give the trees their shape.
    BroadPhase(const ContactMesh& mesh, const VecX& positions);

    /// Vertex-face and edge-edge pairs whose boxes may meet, each once; of bodies that are on; not of two
    /// colliders and not of pairs that share a vertex. `vertex_boxes`: one per vertex.
    std::vector<PairCandidate> pairs(const ContactMesh& mesh, const std::vector<MovingBox>& vertex_boxes,
                                     const std::vector<std::uint8_t>& body_on) const;
    /// Faces whose boxes may meet, under the same conditions, as pairs of face numbers.
    std::vector<std::array<int, 2>> face_pairs(const ContactMesh& mesh,
                                               const std::vector<MovingBox>& vertex_boxes,
                                               const std::vector<std::uint8_t>& body_on) const;

  private:
    struct Simplex {
        std::array<int, 3> vertices{-1, -1, -1};
        std::array<int, 3> owned_vertices{-1, -1, -1}, owned_edges{-1, -1, -1};
        int face = -1;
    };
    struct Tree {
        int root = -1;
        std::vector<int> leaves;
    };
    struct Boxes {
        std::vector<MovingBox> simplices, nodes;
    };
    Boxes fit(const std::vector<MovingBox>& vertex_boxes) const;
    template <class F>
    void for_each_simplex_pair(const ContactMesh& mesh, const std::vector<std::uint8_t>& body_on,
                               const Boxes& boxes, const F& visit) const;

    std::vector<Simplex> simplices_;    ///< in tree order
    std::vector<BoxTree::Node> nodes_;  ///< children after parents; `first` counts simplices
    std::vector<Tree> trees_;           ///< one per body
};

}  // namespace cloth
