#include "sim/contact/broad_phase.h"

#include <algorithm>

#include "base/parallel.h"

namespace cloth {

void ContactMesh::add_body(const ContactBody& body, int vertices,
                           const std::vector<std::array<int, 3>>& triangles,
                           const std::vector<std::array<int, 2>>& segments) {
    const int b = static_cast<int>(bodies.size()), first = vertex_count();
    bodies.push_back(body);
    vertex_body.resize(first + vertices, b);
    std::vector<std::array<int, 2>> found;
    std::vector<std::uint8_t> used(vertices, 0);
    for (const auto& t : triangles) {
        faces.push_back({first + t[0], first + t[1], first + t[2]});
        for (int i = 0; i < 3; ++i) {
            found.push_back({first + std::min(t[i], t[(i + 1) % 3]), first + std::max(t[i], t[(i + 1) % 3])});
            used[t[i]] = 1;
        }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    edges.insert(edges.end(), found.begin(), found.end());
    for (const auto& s : segments) {
        lone_edges.push_back(static_cast<int>(edges.size()));
        edges.push_back({first + s[0], first + s[1]});
        used[s[0]] = used[s[1]] = 1;
    }
    for (int v = 0; v < vertices; ++v) {
        if (!used[v]) lone_points.push_back(first + v);
        vertex_piece.push_back(first + v);
    }
    const auto piece_of = [&](int v) {
        while (vertex_piece[v] != v) v = vertex_piece[v] = vertex_piece[vertex_piece[v]];
        return v;
    };
    for (const auto& [a, b_end] : found) {
        const int p = piece_of(a), q = piece_of(b_end);
        vertex_piece[std::max(p, q)] = std::min(p, q);
    }
    for (int v = first; v < vertex_count(); ++v) vertex_piece[v] = piece_of(v);
}

std::array<int, 4> pair_points(const ContactMesh& mesh, const PairCandidate& pair) {
    if (pair.kind == PairKind::vertex_face) {
        const auto& f = mesh.faces[pair.b];
        return {pair.a, f[0], f[1], f[2]};
    }
    const auto &e = mesh.edges[pair.a], &f = mesh.edges[pair.b];
    return {e[0], e[1], f[0], f[1]};
}

BroadPhase::BroadPhase(const ContactMesh& mesh, const VecX& positions) {
    std::vector<std::uint8_t> owned(mesh.vertex_count(), 0), edge_owned(mesh.edges.size(), 0);
    // Per edge (low, high vertex) its number, to hand each edge to the first face that has it.
    std::vector<std::vector<std::array<int, 2>>> edges_of(mesh.vertex_count());
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        edges_of[mesh.edges[e][0]].push_back({mesh.edges[e][1], static_cast<int>(e)});
    }
    auto own_vertex = [&](int v) {
        if (owned[v]) return -1;
        owned[v] = 1;
        return v;
    };
    std::vector<std::vector<Simplex>> of_body(mesh.bodies.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        Simplex s;
        s.vertices = mesh.faces[f];
        s.face = static_cast<int>(f);
        for (int i = 0; i < 3; ++i) {
            s.owned_vertices[i] = own_vertex(s.vertices[i]);
            const int low = std::min(s.vertices[i], s.vertices[(i + 1) % 3]);
            const int high = std::max(s.vertices[i], s.vertices[(i + 1) % 3]);
            for (const auto& [other, e] : edges_of[low]) {
                if (other == high && !edge_owned[e]) {
                    edge_owned[e] = 1;
                    s.owned_edges[i] = e;
                    break;
                }
            }
        }
        of_body[mesh.vertex_body[s.vertices[0]]].push_back(s);
    }
    for (int e : mesh.lone_edges) {
        Simplex s;
        s.vertices = {mesh.edges[e][0], mesh.edges[e][1], -1};
        s.owned_vertices = {own_vertex(s.vertices[0]), own_vertex(s.vertices[1]), -1};
        s.owned_edges[0] = e;
        of_body[mesh.vertex_body[s.vertices[0]]].push_back(s);
    }
    for (int v : mesh.lone_points) {
        Simplex s;
        s.vertices[0] = s.owned_vertices[0] = own_vertex(v);
        of_body[mesh.vertex_body[v]].push_back(s);
    }

    for (const std::vector<Simplex>& body : of_body) {
        std::vector<Vec3> centres;
        for (const Simplex& simplex : body) {
            Box box;
            for (int v : simplex.vertices) {
                if (v >= 0) box.add(Vec3(positions.segment<3>(3 * v)));
            }
            centres.push_back(0.5 * (box.low + box.high));
        }
        const BoxTree shape(centres);
        const int first_simplex = static_cast<int>(simplices_.size());
        const int first_node = static_cast<int>(nodes_.size());
        for (int i : shape.order) simplices_.push_back(body[i]);
        Tree tree;
        if (!shape.nodes.empty()) tree.root = first_node;
        for (BoxTree::Node node : shape.nodes) {
            node.first += first_simplex;
            if (node.left < 0) {
                tree.leaves.push_back(static_cast<int>(nodes_.size()));
            } else {
                node.left += first_node;
                node.right += first_node;
            }
            nodes_.push_back(node);
        }
        trees_.push_back(tree);
    }
}

BroadPhase::Boxes BroadPhase::fit(const std::vector<MovingBox>& vertex_boxes) const {
    Boxes boxes{std::vector<MovingBox>(simplices_.size()), std::vector<MovingBox>(nodes_.size())};
    parallel_for(static_cast<int>(simplices_.size()), [&](int s) {
        for (int v : simplices_[s].vertices) {
            if (v >= 0) boxes.simplices[s].add(vertex_boxes[v]);
        }
    });
    for (int n = static_cast<int>(nodes_.size()) - 1; n >= 0; --n) {
        const BoxTree::Node& node = nodes_[n];
        MovingBox& box = boxes.nodes[n];
        if (node.left < 0) {
            for (int s = node.first; s < node.first + node.count; ++s) box.add(boxes.simplices[s]);
        } else {
            box.add(boxes.nodes[node.left]);
            box.add(boxes.nodes[node.right]);
        }
    }
    return boxes;
}

template <class F>
void BroadPhase::for_each_simplex_pair(const ContactMesh& mesh, const std::vector<std::uint8_t>& body_on,
                                       const Boxes& boxes, const F& visit) const {
    // Every leaf against the trees that come after it (and the later leaves of its own tree); one list a
    // leaf.
    std::vector<std::array<int, 2>> tasks;  // body, leaf
    for (std::size_t b = 0; b < trees_.size(); ++b) {
        if (!body_on[b]) continue;
        for (int leaf : trees_[b].leaves) tasks.push_back({static_cast<int>(b), leaf});
    }
    parallel_for(static_cast<int>(tasks.size()), [&](int task) {
        const auto [body, leaf_number] = tasks[task];
        const BoxTree::Node& leaf = nodes_[leaf_number];
        std::array<int, 128> stack;
        for (std::size_t c = body; c < trees_.size(); ++c) {
            if (!body_on[c] || trees_[c].root < 0) continue;
            const bool same = static_cast<int>(c) == body;
            if (mesh.bodies[body].collider && mesh.bodies[c].collider) continue;
            int depth = 0;
            stack[depth++] = trees_[c].root;
            while (depth > 0) {
                const int number = stack[--depth];
                const BoxTree::Node& node = nodes_[number];
                // Simplices are numbered in tree order: what ends before this leaf has met it already.
                if (same && node.first + node.count <= leaf.first) continue;
                if (!may_meet(boxes.nodes[leaf_number], boxes.nodes[number])) continue;
                if (node.left >= 0) {
                    stack[depth++] = node.right;
                    stack[depth++] = node.left;
                    continue;
                }
                for (int s = leaf.first; s < leaf.first + leaf.count; ++s) {
                    for (int r = node.first; r < node.first + node.count; ++r) {
                        if (same && r <= s) continue;
                        if (may_meet(boxes.simplices[s], boxes.simplices[r])) visit(task, s, r);
                    }
                }
            }
        }
    });
}

std::vector<PairCandidate> BroadPhase::pairs(const ContactMesh& mesh,
                                             const std::vector<MovingBox>& vertex_boxes,
                                             const std::vector<std::uint8_t>& body_on) const {
    const Boxes boxes = fit(vertex_boxes);
    std::vector<MovingBox> edge_boxes(mesh.edges.size()), face_boxes(mesh.faces.size());
    parallel_for(static_cast<int>(mesh.edges.size()), [&](int e) {
        for (int v : mesh.edges[e]) edge_boxes[e].add(vertex_boxes[v]);
    });
    parallel_for(static_cast<int>(mesh.faces.size()), [&](int f) {
        for (int v : mesh.faces[f]) face_boxes[f].add(vertex_boxes[v]);
    });
    std::size_t leaf_count = 0;
    for (const Tree& tree : trees_) leaf_count += tree.leaves.size();
    std::vector<std::vector<PairCandidate>> found(leaf_count);
    auto vertices_against_face = [&](const Simplex& s, const Simplex& r, std::vector<PairCandidate>& out) {
        if (r.face < 0) return;
        const auto& f = mesh.faces[r.face];
        for (int v : s.owned_vertices) {
            if (v < 0 || v == f[0] || v == f[1] || v == f[2]) continue;
            if (may_meet(vertex_boxes[v], face_boxes[r.face])) {
                out.push_back({PairKind::vertex_face, v, r.face});
            }
        }
    };
    for_each_simplex_pair(mesh, body_on, boxes, [&](int task, int s_number, int r_number) {
        const Simplex &s = simplices_[s_number], &r = simplices_[r_number];
        auto& out = found[task];
        vertices_against_face(s, r, out);
        vertices_against_face(r, s, out);
        for (int e : s.owned_edges) {
            if (e < 0) continue;
            for (int g : r.owned_edges) {
                if (g < 0) continue;
                const auto &p = mesh.edges[e], &q = mesh.edges[g];
                if (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1]) continue;
                if (may_meet(edge_boxes[e], edge_boxes[g])) {
                    out.push_back({PairKind::edge_edge, std::min(e, g), std::max(e, g)});
                }
            }
        }
    });
    // Edges of one simplex always share a vertex, and its vertices are its face's own: nothing within one.
    std::vector<PairCandidate> all;
    for (const auto& list : found) all.insert(all.end(), list.begin(), list.end());
    return all;
}

std::vector<std::array<int, 2>> BroadPhase::face_pairs(const ContactMesh& mesh,
                                                       const std::vector<MovingBox>& vertex_boxes,
                                                       const std::vector<std::uint8_t>& body_on) const {
    const Boxes boxes = fit(vertex_boxes);
    std::size_t leaf_count = 0;
    for (const Tree& tree : trees_) leaf_count += tree.leaves.size();
    std::vector<std::vector<std::array<int, 2>>> found(leaf_count);
    for_each_simplex_pair(mesh, body_on, boxes, [&](int task, int s, int r) {
        const int f = simplices_[s].face, g = simplices_[r].face;
        if (f < 0 || g < 0) return;
        for (int v : mesh.faces[f]) {
            for (int w : mesh.faces[g]) {
                if (v == w) return;
            }
        }
        found[task].push_back({std::min(f, g), std::max(f, g)});
    });
    std::vector<std::array<int, 2>> all;
    for (const auto& list : found) all.insert(all.end(), list.begin(), list.end());
    std::sort(all.begin(), all.end());
    return all;
}

}  // namespace cloth
