#include "sim/contact/barrier_contact.h"

#include <algorithm>
#include <cstdint>

#include "base/parallel.h"

namespace cloth {
namespace {

/// Blocks of the upper triangle of a pair's 4 x 4, row by row.
constexpr int block_count = 10;
constexpr std::array<int, block_count> rows{0, 0, 0, 0, 1, 1, 1, 2, 2, 3},
    columns{0, 1, 2, 3, 1, 2, 3, 2, 3, 3};

/// Where each block of a pair goes: what BlockPattern::find() says, or
constexpr int nowhere = -2, outside_pattern = -1;
using Slots = std::array<int, block_count>;

/// `n`: vertices that move.
Slots slots_of(const BlockPattern& pattern, int n, const std::array<int, 4>& points, int split) {
    Slots slots;
    auto moves = [&](int v) { return v >= 0 && v < n; };
    auto couples = [&](int b) { return rows[b] < split && columns[b] >= split; };
    bool coupled_inside = true;
    for (int b = 0; b < block_count; ++b) {
        const int v = points[rows[b]], w = points[columns[b]];
        slots[b] = moves(v) && moves(w) ? pattern.find(v, w) : nowhere;
        if (couples(b) && slots[b] == outside_pattern) coupled_inside = false;
    }
    for (int b = 0; b < block_count; ++b) {
        if (!coupled_inside && couples(b) && slots[b] != nowhere) slots[b] = outside_pattern;
    }
    return slots;
}

}  // namespace

void ExtraBlocks::add_product(const VecX& x, VecX& y) const {
    for (std::size_t b = 0; b < where.size(); ++b) {
        const auto [i, j] = where[b];
        y.segment<3>(3 * i) += blocks[b] * x.segment<3>(3 * j);
        y.segment<3>(3 * j) += blocks[b].transpose() * x.segment<3>(3 * i);
    }
}

double BarrierContact::value(const VecX& x) const {
    std::vector<Contact> memory;
    const std::vector<Contact>& contacts = set_.contacts(x, memory);
    double sum = parallel_sum(static_cast<int>(contacts.size()), [&](int i) {
        return contact_value(contacts[i], set_.colliders().points(x, contacts[i].points));
    });
    set_.friction().add_value(x, sum);
    return sum;
}

void BarrierContact::add_gradient(const VecX& x, VecX& g) const {
    std::vector<Contact> memory;
    const int n = set_.system().cloth_vertices;
    const std::vector<Contact>& contacts = set_.contacts(x, memory);
    std::vector<Vec12> gradients(contacts.size());
    parallel_for(static_cast<int>(contacts.size()), [&](int k) {
        gradients[k] = contact_gradient(contacts[k], set_.colliders().points(x, contacts[k].points));
    });
    for (std::size_t k = 0; k < contacts.size(); ++k) {
        for (int i = 0; i < 4; ++i) {
            const int v = contacts[k].points[i];
            if (v >= 0 && v < n) g.segment<3>(3 * v) += gradients[k].segment<3>(3 * i);
        }
    }
    set_.friction().add_gradient(x, g);
}

void BarrierContact::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    ExtraBlocks extra;
    add_hessian(x, kind, kind, H, extra);
}

void BarrierContact::add_hessian(const VecX& x, HessianKind kind, HessianKind slides, BlockMatrix& H,
                                 ExtraBlocks& extra) const {
    const int n = set_.system().cloth_vertices;
    std::vector<Contact> memory;
    const std::vector<Contact>& contacts = set_.contacts(x, memory);
    const FrictionList& friction = set_.friction();
    const int contact_count = static_cast<int>(contacts.size());
    const int friction_count = static_cast<int>(friction.items.size());
    std::vector<Slots> slots(contact_count + friction_count);
    std::vector<Mat12>& contact_hessians = extra.pairs;
    contact_hessians.resize(contact_count);
    parallel_for(contact_count, [&](int k) {
        const Contact& c = contacts[k];
        contact_hessians[k] = contact_hessian(c, set_.colliders().points(x, c.points), kind);
        slots[k] = slots_of(*pattern_, n, c.points, c.split());
    });
    const double curvature = slides == HessianKind::exact ? 1.0 : 0.8;
    std::vector<Mat3> friction_hessians(friction_count);
    parallel_for(friction_count, [&](int k) {
        const Friction& f = friction.items[k];
        friction_hessians[k] = friction.hessian(k, x, curvature);
        slots[contact_count + k] = slots_of(*pattern_, n, f.points, f.split);
    });
    auto points_of = [&](int k) -> const std::array<int, 4>& {
        return k < contact_count ? contacts[k].points : friction.items[k - contact_count].points;
    };
    // Block b of pair k, as it stands above the diagonal.
    auto upper = [&](int k, int b) -> Mat3 {
        if (k >= contact_count) {
            const Friction& f = friction.items[k - contact_count];
            return f.weights[rows[b]] * f.weights[columns[b]] * friction_hessians[k - contact_count];
        }
        const Mat3 block = contact_hessians[k].block<3, 3>(3 * rows[b], 3 * columns[b]);
        return contacts[k].points[rows[b]] <= contacts[k].points[columns[b]] ? block
                                                                             : Mat3(block.transpose());
    };

    struct Outside {
        std::uint64_t where;  ///< row, column
        int pair, block;
    };
    std::vector<Outside> outside;
    for (int k = 0; k < contact_count + friction_count; ++k) {
        for (int b = 0; b < block_count; ++b) {
            const int slot = slots[k][b];
            if (slot >= 0) {
                H.blocks[slot] += upper(k, b);
            } else if (slot == outside_pattern) {
                const auto& points = points_of(k);
                const auto [low, high] = std::minmax(points[rows[b]], points[columns[b]]);
                outside.push_back(
                    {static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high), k, b});
            }
        }
    }
    std::sort(outside.begin(), outside.end(), [](const Outside& a, const Outside& b) {
        return a.where != b.where ? a.where < b.where
               : a.pair != b.pair ? a.pair < b.pair
                                  : a.block < b.block;
    });
    extra.where.clear();
    extra.blocks.clear();
    std::uint64_t last = ~std::uint64_t{0};
    for (const Outside& o : outside) {
        if (o.where != last) {
            last = o.where;
            extra.where.push_back({static_cast<int>(o.where >> 32), static_cast<int>(o.where & 0xffffffffu)});
            extra.blocks.push_back(Mat3::Zero());
        }
        extra.blocks.back() += upper(o.pair, o.block);
    }
}

void BarrierContact::add_placing_gradient(const VecX& x, VecX& g) const {
    const MovingColliders& colliders = set_.colliders();
    if (colliders.placed()) return;
    std::vector<Contact> memory;
    const int n = set_.system().cloth_vertices;
    for (const Contact& c : set_.contacts(x, memory)) {
        if (c.plane >= 0) {
            const auto &now = colliders.plane(c.plane), &target = colliders.plane_target(c.plane);
            const Vec3 y = x.segment<3>(3 * c.points[0]) - now.point;
            const double closing =
                (target.normal - now.normal).dot(y) - c.normal.dot(target.point - now.point);
            g.segment<3>(3 * c.points[0]) +=
                barrier(c.gap, c.activation, c.stiffness).second * closing * c.normal;
        } else if (c.collider >= 0) {
            Vec12 way = Vec12::Zero();
            for (int i = 0; i < 4; ++i) {
                if (c.points[i] >= n) way.segment<3>(3 * i) = colliders.way_of(c.points[i]);
            }
            const Vec12 change =
                contact_hessian(c, colliders.points(x, c.points), HessianKind::projected) * way;
            for (int i = 0; i < 4; ++i) {
                if (c.points[i] < n) g.segment<3>(3 * c.points[i]) += change.segment<3>(3 * i);
            }
        }
    }
}

void BarrierContact::append_pairs(std::vector<std::array<int, 2>>& pairs) const {
    const int n = set_.system().cloth_vertices;
    for (const Candidate& c : set_.candidates().list()) {
        for (int i = 0; i < 4; ++i) {
            for (int j = i + 1; j < 4; ++j) {
                if (c.points[i] < n && c.points[j] < n) pairs.push_back({c.points[i], c.points[j]});
            }
        }
    }
}

}  // namespace cloth
