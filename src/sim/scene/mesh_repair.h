#pragma once
// From triangles as modellers leave them to those of a cloth.

#include <vector>

#include "sim/scene/scene.h"

namespace cloth {

/// A mesh that has been mended, and what was done.
struct MeshRepair {
    MeshData mesh;
    std::vector<int> vertex_of;  ///< of each vertex that was given: the one it is now; -1: left out
    std::vector<int> given;      ///< of each vertex: the first of those that it was
    int joined = 0;              ///< vertices that went into another
    int doubled = 0;             ///< vertices that stand where another stands and were left there
    int loose = 0;               ///< vertices of no triangle, left out
    int collapsed = 0;           ///< triangles with a repeated corner, left out
    int repeated = 0;            ///< triangles of the same corners as an earlier one, left out
    int turned = 0;              ///< triangles turned over
};

/// Joins vertices that stand at one place (in the pose too, where there is one), leaves out what belongs to
/// no sheet, and turns triangles so that each connected piece faces one way: the way that most of its area
/// faces, which turns least of what a modeller shows; of two halves the first triangle's way. Order is kept;
/// a mesh with nothing to mend comes back to the bit. One place is: nearer than a hundredth of the shortest
/// edge and 1e-5 of the mesh's size. What no repair can help is left for check_cloth_mesh(). Requires corners
/// within range.
MeshRepair repair_cloth_mesh(const MeshData& mesh, const Points* pose, bool weld);

}  // namespace cloth
