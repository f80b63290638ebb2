#pragma once
// Which pairs may touch: a tree of boxes over each body's simplices. The trees' shapes are built once, from
// rest positions, where neighbours in the cloth are neighbours in space for the whole run; the boxes are
// fitted to each question. Of two lists, what both contain stands in the same order.

#include <array>
#include <cmath>
#include <compare>
#include <limits>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/geometry/box_tree.h"
#include "sim/geometry/collide.h"

namespace cloth {

/// Of points that go straight ways in the same time: the box around where they are at the start, and that at
/// the end. In between, they lie within the interpolated bounds. In single precision, rounded outwards, and
/// in lanes (x, y, z, unused), so that two meet in a few instructions: most of detection is that.
struct MovingBox {
    using Corner [[gnu::vector_size(16)]] = float;
    Corner start_low = empty_low, start_high = -empty_low, end_low = empty_low, end_high = -empty_low;

    MovingBox() = default;
    /// Around one point from `start` to `end`, and `reach` about it [m].
    MovingBox(const Vec3& start, const Vec3& end, double reach)
        : start_low(corner(start, reach, -1.0)),
          start_high(corner(start, reach, 1.0)),
          end_low(corner(end, reach, -1.0)),
          end_high(corner(end, reach, 1.0)) {}

    void add(const MovingBox& b) {
        start_low = b.start_low < start_low ? b.start_low : start_low;
        start_high = b.start_high > start_high ? b.start_high : start_high;
        end_low = b.end_low < end_low ? b.end_low : end_low;
        end_high = b.end_high > end_high ? b.end_high : end_high;
    }

  private:
    static constexpr float far = std::numeric_limits<float>::infinity();
    static constexpr Corner empty_low{far, far, far, far};

    static Corner corner(const Vec3& p, double reach, double outwards) {
        Corner c{0.0F, 0.0F, 0.0F, 0.0F};
        for (int k = 0; k < 3; ++k) {
            const double exact = p(k) + outwards * reach;
            c[k] = static_cast<float>(exact + outwards * 1e-7 * std::abs(exact));  // rounds by 6e-8 at most
        }
        return c;
    }
};
/// False where an axis keeps the two apart at the start and, the same way round, at the end: then it does so
/// at every time between.
inline bool may_meet(const MovingBox& a, const MovingBox& b) {
    const auto apart = ((a.start_low > b.start_high) & (a.end_low > b.end_high)) |
                       ((b.start_low > a.start_high) & (b.end_low > a.end_high));
    return (apart[0] | apart[1] | apart[2]) == 0;
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
