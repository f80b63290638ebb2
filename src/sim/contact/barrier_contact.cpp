#include "sim/contact/barrier_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "base/parallel.h"

namespace cloth {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// In activation distances: how far from the ways that detection was made for its result holds, along each
/// axis.
constexpr double margin_factor = 1.0;
/// In activation distances: how far along a way collisions are looked for at first.
constexpr double first_piece = 3.0;
/// Share of a gap that a step must leave.
constexpr double slack = 0.2;

/// Elements of a list in the order of their chunks: find(i, out) may append to out.
template <class T, class F>
std::vector<T> collect(int count, const F& find) {
    constexpr int chunk = 512;
    std::vector<std::vector<T>> parts((count + chunk - 1) / chunk);
    parallel_tasks(static_cast<int>(parts.size()), [&](int p) {
        for (int i = p * chunk; i < std::min(count, (p + 1) * chunk); ++i) find(i, parts[p]);
    });
    std::vector<T> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// Least of find(i) ≤ 1, in parallel; a minimum has no order.
template <class F>
double least_share(int count, const F& find) {
    return parallel_reduce(count, 1.0, find, [](double a, double b) { return std::min(a, b); });
}

struct Derivatives {
    double value, first, second;
};

/// κ B and its derivatives with respect to the gap.
Derivatives barrier(double gap, double activation, double stiffness) {
    if (gap >= activation) return {0.0, 0.0, 0.0};
    if (!(gap > 0.0)) return {infinity, -infinity, infinity};
    const double z = gap / activation, y = 1.0 - z;
    return {
        stiffness * y * y * y / z, -stiffness / activation * y * y * (3.0 - 2.0 * y) / (z * z),
        stiffness / (activation * activation) * 2.0 * y * (3.0 * z * z + y * (3.0 - 2.0 * y)) / (z * z * z)};
}

/// φ(u)/u-like factors: φ, φ'/u, and (φ'' - φ'/u)/u².
struct Slide {
    double value, slope, curvature;
};
Slide slide(double u, double way) {
    if (u >= way) return {u - way / 3.0, 1.0 / u, -1.0 / (u * u * u)};
    const double value = u * u / way - u * u * u / (3.0 * way * way);
    return {value, 2.0 / way - u / (way * way), u > 0.0 ? -1.0 / (u * way * way) : 0.0};
}

int find_slot(const BlockPattern& pattern, int i, int j) {
    const auto begin = pattern.column.begin() + pattern.row_begin[i];
    const auto end = pattern.column.begin() + pattern.row_begin[i + 1];
    const auto it = std::lower_bound(begin, end, j);
    return it != end && *it == j ? static_cast<int>(it - pattern.column.begin()) : -1;
}

/// |e1 x e2|² with its gradient and Hessian over the four points.
template <class Vec12, class Mat12>
double cross_squared(const FourPoints& x, Vec12& gradient, Mat12& hessian) {
    const Vec3 e = x[1] - x[0], f = x[3] - x[2];
    const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f);
    const Vec3 ge = 2.0 * (ff * e - ef * f), gf = 2.0 * (ee * f - ef * e);
    const Mat3 I = Mat3::Identity();
    const Mat3 Hee = 2.0 * (ff * I - f * f.transpose()), Hff = 2.0 * (ee * I - e * e.transpose());
    const Mat3 Hef = 4.0 * e * f.transpose() - 2.0 * f * e.transpose() - 2.0 * ef * I;
    gradient << -ge, ge, -gf, gf;
    const double s[2] = {-1.0, 1.0};
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            hessian.template block<3, 3>(3 * i, 3 * j) = s[i] * s[j] * Hee;
            hessian.template block<3, 3>(6 + 3 * i, 6 + 3 * j) = s[i] * s[j] * Hff;
            hessian.template block<3, 3>(3 * i, 6 + 3 * j) = s[i] * s[j] * Hef;
            hessian.template block<3, 3>(6 + 3 * j, 3 * i) = s[i] * s[j] * Hef.transpose();
        }
    }
    return e.cross(f).squaredNorm();
}

/// Changes of the weights that shift the nearest points by orthonormal tangents.
struct Tangents {
    int count = 0;
    std::array<std::array<double, 4>, 2> weights{};  ///< u_k
    std::array<Vec3, 2> directions;                  ///< t_k
};
Tangents tangents_of(const Nearest& n, const FourPoints& x) {
    Tangents t;
    for (int k = 0; k < n.slide_count; ++k) {
        std::array<double, 4> u = n.slides[k];
        Vec3 p = Vec3::Zero();
        for (int i = 0; i < 4; ++i) p += u[i] * x[i];
        const double full = p.norm();
        for (int m = 0; m < t.count; ++m) {
            const double share = p.dot(t.directions[m]);
            p -= share * t.directions[m];
            for (int i = 0; i < 4; ++i) u[i] -= share * t.weights[m][i];
        }
        const double length = p.norm();
        if (!(length > 1e-12 * full)) continue;
        for (double& w : u) w /= length;
        t.weights[t.count] = u;
        t.directions[t.count++] = p / length;
    }
    return t;
}

}  // namespace

void ExtraBlocks::add_product(const VecX& x, VecX& y) const {
    for (std::size_t b = 0; b < where.size(); ++b) {
        const auto [i, j] = where[b];
        y.segment<3>(3 * i) += blocks[b] * x.segment<3>(3 * j);
        y.segment<3>(3 * j) += blocks[b].transpose() * x.segment<3>(3 * i);
    }
}

BarrierContact::BarrierContact(ContactSystem system)
    : system_(std::move(system)), broad_phase_(system_.mesh, system_.rest) {
    int collider_count = 0;
    for (const ContactBody& body : system_.mesh.bodies) {
        collider_of_body_.push_back(body.collider ? body.index : -1);
        if (body.collider) collider_count = std::max(collider_count, body.index + 1);
    }
    for (const auto& plane : system_.planes) collider_count = std::max(collider_count, plane.collider + 1);
    from_.resize(collider_count);
    to_.resize(collider_count);
    on_.assign(collider_count, 1);
    body_on_.assign(system_.mesh.bodies.size(), 1);
    const int n = system_.cloth_vertices;
    colliders_ = collider_target_ = system_.rest.tail(system_.rest.size() - 3 * n);
    for (const auto& plane : system_.planes) {
        plane_points_.push_back(plane.point);
        plane_normals_.push_back(plane.normal);
    }
    plane_point_targets_ = plane_points_;
    plane_normal_targets_ = plane_normals_;
}

FourPoints BarrierContact::gather(const VecX& x, const std::array<int, 4>& points) const {
    return {point(x, points[0]), point(x, points[1]), point(x, points[2]), point(x, points[3])};
}

void BarrierContact::begin(const VecX& x, const VecX& slide_from, double h,
                           const std::vector<Placement>& from, const std::vector<Placement>& to,
                           const std::vector<std::uint8_t>& on) {
    const int n = system_.cloth_vertices;
    const auto& mesh = system_.mesh;
    if (on != on_) covered_ = false;
    from_ = from;
    to_ = to;
    on_ = on;
    for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
        body_on_[b] = collider_of_body_[b] < 0 || on_[collider_of_body_[b]];
    }
    for (int v = n; v < mesh.vertex_count(); ++v) {
        const int c = collider_of_body_[mesh.vertex_body[v]];
        const Vec3 p = system_.rest.segment<3>(3 * v);
        colliders_.segment<3>(3 * (v - n)) = from_[c](p);
        collider_target_.segment<3>(3 * (v - n)) = to_[c](p);
    }
    bool moving = colliders_ != collider_target_;
    for (std::size_t p = 0; p < system_.planes.size(); ++p) {
        const auto& plane = system_.planes[p];
        plane_points_[p] = from_[plane.collider](plane.point);
        plane_normals_[p] = from_[plane.collider].rotation * plane.normal;
        plane_point_targets_[p] = to_[plane.collider](plane.point);
        plane_normal_targets_[p] = to_[plane.collider].rotation * plane.normal;
        moving = moving || plane_points_[p] != plane_point_targets_[p] ||
                 plane_normals_[p] != plane_normal_targets_[p];
    }
    way_left_ = moving ? 1.0 : 0.0;
    contacts_known_ = false;
    sliding_way_ = system_.sliding_speed * h;
    friction_.clear();
    for (const Contact& c : contacts(x)) {
        if (c.friction == 0.0) continue;
        double mollifier = 1.0;
        if (c.mollifier > 0.0) {
            const FourPoints y = gather(x, c.points);
            const double z = (y[1] - y[0]).cross(y[3] - y[2]).squaredNorm() / c.mollifier;
            if (z < 1.0) mollifier = (2.0 - z) * z;
        }
        const double normal_force = -mollifier * barrier(c.gap, c.activation, c.stiffness).first;
        if (!(normal_force > 0.0)) continue;
        Friction f{c.points,     c.nearest.weights,         c.normal,
                   Vec3::Zero(), c.friction * normal_force, c.edges ? 2 : 1};
        Vec3 on_collider = Vec3::Zero();
        double side = 0.0;
        int body = -1;
        for (int i = 0; i < 4; ++i) {
            const int v = c.points[i];
            if (v < 0) continue;
            if (v < n) {
                f.start += f.weights[i] * slide_from.segment<3>(3 * v);
            } else {
                side += f.weights[i];
                on_collider += f.weights[i] * point(x, v);
                body = mesh.vertex_body[v];
            }
        }
        if (c.collider >= 0) {
            if (c.flat) {
                on_collider = Vec3(x.segment<3>(3 * c.points[0])) - c.distance * c.normal;
                side = -1.0;
            } else {
                on_collider = on_collider / side - (side * mesh.bodies[body].radius) * c.normal;
            }
            const Vec3 at_rest =
                from_[c.collider].rotation.transpose() * (on_collider - from_[c.collider].translation);
            f.start -= side * (to_[c.collider](at_rest) - on_collider);
        }
        friction_.push_back(f);
    }
}

void BarrierContact::place(double share) {
    if (share >= 1.0) {
        colliders_ = collider_target_;
        plane_points_ = plane_point_targets_;
        plane_normals_ = plane_normal_targets_;
        way_left_ = 0.0;
    } else {
        colliders_ += share * (collider_target_ - colliders_);
        for (std::size_t p = 0; p < plane_points_.size(); ++p) {
            plane_points_[p] += share * (plane_point_targets_[p] - plane_points_[p]);
            plane_normals_[p] =
                ((1.0 - share) * plane_normals_[p] + share * plane_normal_targets_[p]).normalized();
        }
        way_left_ *= 1.0 - share;
    }
    contacts_known_ = false;
}

// ---------------------------------------------------------------- detection

BarrierContact::Candidate BarrierContact::make_candidate(const PairCandidate& pair) const {
    const auto& mesh = system_.mesh;
    const int n = system_.cloth_vertices;
    Candidate c{pair.kind, pair_points(mesh, pair), 0.0, system_.activation, 0.0, 0.0, 0.0};
    const int split = pair.kind == PairKind::vertex_face ? 1 : 2;
    const int a = mesh.vertex_body[c.points[0]], b = mesh.vertex_body[c.points[split]];
    c.offset = mesh.bodies[a].radius + mesh.bodies[b].radius;
    c.friction = std::sqrt(system_.friction[a] * system_.friction[b]);
    double mass[2] = {0.0, 0.0};
    for (int i = 0; i < 4; ++i) {
        const int side = i < split ? 0 : 1;
        mass[side] += c.points[i] < n ? system_.mass[c.points[i]] : infinity;
    }
    mass[0] /= split;
    mass[1] /= 4 - split;
    FourPoints rest;
    for (int i = 0; i < 4; ++i) rest[i] = system_.rest.segment<3>(3 * c.points[i]);
    // Whether neighbours in the rest shape may be near: a bound first, for most are not.
    const double spans =
        (rest[split] - rest[0]).norm() - (split == 2 ? (rest[1] - rest[0]).norm() : 0.0) -
        std::max((rest[3] - rest[split]).norm(), split == 1 ? (rest[2] - rest[1]).norm() : 0.0);
    if (a == b && spans < 4.0 * c.offset + 2.0 * c.activation) {
        // Neighbours in a fine mesh stand nearer than the thickness at rest; they meet where that is halved.
        const double apart = std::sqrt(nearest(pair.kind, rest).distance_squared);
        c.offset = std::min(c.offset, 0.25 * apart);
        c.activation = std::min(c.activation, 0.5 * apart);
    }
    c.stiffness = std::min(mass[0], mass[1]) * c.activation * system_.acceleration;
    if (pair.kind == PairKind::edge_edge) {
        c.mollifier = 1e-3 * (rest[1] - rest[0]).squaredNorm() * (rest[3] - rest[2]).squaredNorm();
    }
    return c;
}

void BarrierContact::detect() const {
    ++detections_;
    const auto& mesh = system_.mesh;
    const double margin = margin_factor * system_.activation;
    auto start = [&](int v) { return Vec3(covered_from_.segment<3>(3 * v)); };
    auto way = [&](int v) { return Vec3(covered_way_.segment<3>(3 * v)); };
    std::vector<MovingBox> boxes(mesh.vertex_count());
    parallel_for(mesh.vertex_count(), [&](int v) {
        boxes[v].start.add(start(v));
        boxes[v].end.add(Vec3(start(v) + way(v)));
        boxes[v].inflate(margin + mesh.bodies[mesh.vertex_body[v]].radius + 0.5 * system_.activation);
    });
    const std::vector<PairCandidate> boxed = broad_phase_.pairs(mesh, boxes, body_on_);
    candidates_ = collect<Candidate>(static_cast<int>(boxed.size()), [&](int i, std::vector<Candidate>& out) {
        const auto points = pair_points(mesh, boxed[i]);
        const bool face = boxed[i].kind == PairKind::vertex_face;
        FourPoints x;
        Vec3 mean = Vec3::Zero();
        for (int j = 0; j < 4; ++j) {
            x[j] = start(points[j]);
            mean += 0.25 * way(points[j]);
        }
        std::array<double, 4> ways;
        for (int j = 0; j < 4; ++j) ways[j] = (way(points[j]) - mean).norm();
        const double closing = face ? ways[0] + std::max({ways[1], ways[2], ways[3]})
                                    : std::max(ways[0], ways[1]) + std::max(ways[2], ways[3]);
        const double far = closing + 2.0 * 1.7321 * margin + system_.activation +
                           mesh.bodies[mesh.vertex_body[points[0]]].radius +
                           mesh.bodies[mesh.vertex_body[points[face ? 1 : 2]]].radius;
        if (boxes_apart(boxed[i].kind, x, far)) return;
        if (nearest(boxed[i].kind, x).distance_squared <= far * far) out.push_back(make_candidate(boxed[i]));
    });
    contacts_known_ = false;
}

void BarrierContact::cover(const VecX& x, const VecX& d, bool colliders_move) const {
    const int n = system_.cloth_vertices, count = system_.mesh.vertex_count();
    VecX from(3 * count), way(3 * count);
    from << x, colliders_;
    way.head(3 * n) = d;
    if (colliders_move) {
        way.tail(3 * (count - n)) = collider_target_ - colliders_;
    } else {
        way.tail(3 * (count - n)).setZero();
    }
    if (covered_) {
        // The same share of the covered ways for all points, and what each is off it.
        const double length_squared = covered_way_.head(3 * n).squaredNorm();
        auto off = [&](const VecX& p) {
            const VecX moved = p - covered_from_;
            double share = 0.0;
            if (length_squared > 0.0) {
                share =
                    std::clamp(moved.head(3 * n).dot(covered_way_.head(3 * n)) / length_squared, 0.0, 1.0);
            }
            const VecX error = moved - share * covered_way_;
            return error.size() > 0 ? error.cwiseAbs().maxCoeff() : 0.0;
        };
        const double margin = margin_factor * system_.activation;
        if (off(from) <= margin && off(from + way) <= margin) return;
    }
    covered_from_ = std::move(from);
    covered_way_ = std::move(way);
    covered_ = true;
    detect();
}

const std::vector<BarrierContact::Contact>& BarrierContact::contacts(const VecX& x) const {
    if (contacts_known_ && contacts_at_ == x) return contacts_;
    cover(x, VecX::Zero(x.size()), false);
    contacts_ = collect<Contact>(static_cast<int>(candidates_.size()), [&](int i, std::vector<Contact>& out) {
        const Candidate& k = candidates_[i];
        const FourPoints p = gather(x, k.points);
        const double far = k.offset + k.activation;
        if (boxes_apart(k.kind, p, far)) return;
        const Nearest n = nearest(k.kind, p);
        if (n.distance_squared >= far * far) return;
        Contact c;
        c.points = k.points;
        c.nearest = n;
        c.distance = std::sqrt(n.distance_squared);
        c.normal = c.distance > 0.0 ? Vec3(n.difference(p) / c.distance) : Vec3(Vec3::UnitY());
        c.gap = c.distance - k.offset;
        c.activation = k.activation;
        c.stiffness = k.stiffness;
        c.mollifier = k.mollifier;
        c.friction = k.friction;
        c.edges = k.kind == PairKind::edge_edge;
        for (int v : k.points)
            c.collider = std::max(c.collider, collider_of_body_[system_.mesh.vertex_body[v]]);
        out.push_back(c);
    });
    const int n = system_.cloth_vertices;
    for (std::size_t p = 0; p < system_.planes.size(); ++p) {
        const auto& plane = system_.planes[p];
        if (!on_[plane.collider]) continue;
        const auto found = collect<Contact>(n, [&](int v, std::vector<Contact>& out) {
            const int body = system_.mesh.vertex_body[v];
            Contact c;
            c.distance = plane_normals_[p].dot(x.segment<3>(3 * v) - plane_points_[p]);
            c.gap = c.distance - plane.radius - system_.mesh.bodies[body].radius;
            if (c.gap >= system_.activation) return;
            c.points = {v, -1, -1, -1};
            c.nearest = nearest_point_point(Vec3::Zero(), Vec3::Zero());
            c.nearest.weights = {1.0, 0.0, 0.0, 0.0};
            c.normal = plane_normals_[p];
            c.activation = system_.activation;
            c.stiffness = system_.mass[v] * system_.activation * system_.acceleration;
            c.mollifier = 0.0;
            c.friction = std::sqrt(plane.friction * system_.friction[body]);
            c.flat = true;
            c.collider = plane.collider;
            out.push_back(c);
        });
        contacts_.insert(contacts_.end(), found.begin(), found.end());
    }
    contacts_at_ = x;
    contacts_known_ = true;
    return contacts_;
}

// ---------------------------------------------------------------- energy

namespace {

/// c/c₀ of the mollifier below 1, else 1.
struct Mollifier {
    double value = 1.0, first = 0.0, second = 0.0;
};
Mollifier mollify(double c, double c0) {
    const double z = c / c0;
    if (!(c0 > 0.0) || z >= 1.0) return {};
    return {(2.0 - z) * z, (2.0 - 2.0 * z) / c0, -2.0 / (c0 * c0)};
}

double cross_squared(const FourPoints& x) {
    return (x[1] - x[0]).cross(x[3] - x[2]).squaredNorm();
}

}  // namespace

BarrierContact::Vec12 BarrierContact::contact_gradient(const Contact& c, const FourPoints& x) {
    const Derivatives b = barrier(c.gap, c.activation, c.stiffness);
    Vec12 g;
    for (int i = 0; i < 4; ++i) g.segment<3>(3 * i) = b.first * c.nearest.weights[i] * c.normal;
    if (c.mollifier > 0.0 && cross_squared(x) < c.mollifier) {
        Vec12 gc;
        Mat12 Hc;
        const Mollifier m = mollify(cloth::cross_squared(x, gc, Hc), c.mollifier);
        g = m.value * g + m.first * b.value * gc;
    }
    return g;
}

BarrierContact::Mat12 BarrierContact::contact_hessian(const Contact& c, const FourPoints& x,
                                                      HessianKind kind) {
    const Derivatives b = barrier(c.gap, c.activation, c.stiffness);
    const auto& w = c.nearest.weights;
    Vec12 gd;
    for (int i = 0; i < 4; ++i) gd.segment<3>(3 * i) = w[i] * c.normal;
    Mat12 H = b.second * gd * gd.transpose();
    if (c.flat) return H;
    const bool mollified = c.mollifier > 0.0 && cross_squared(x) < c.mollifier;
    const Tangents t = tangents_of(c.nearest, x);
    const bool exact = kind == HessianKind::exact || mollified;
    Mat3 rest = Mat3::Identity() - c.normal * c.normal.transpose();
    for (int k = 0; k < t.count; ++k) {
        rest -= t.directions[k] * t.directions[k].transpose();
        Vec12 a, s;
        for (int i = 0; i < 4; ++i) {
            a.segment<3>(3 * i) = t.weights[k][i] * c.normal;
            s.segment<3>(3 * i) = w[i] * t.directions[k];
        }
        if (exact) {
            H -= b.first * (c.distance * a * a.transpose() + a * s.transpose() + s * a.transpose());
            continue;
        }
        const double aa = a.squaredNorm(), ss = s.squaredNorm();
        const double root = std::sqrt(c.distance * c.distance * aa * aa + 4.0 * aa * ss);
        const double eigenvalue = 0.5 * (c.distance * aa + root);
        if (!(eigenvalue > 0.0)) continue;
        // Eigenvector over (a/|a|, s/|s|): (λ, |a||s|), of length² λ² + |a|²|s|².
        const Vec12 v = eigenvalue / std::sqrt(aa) * a + std::sqrt(aa) * s;
        H += (-b.first * eigenvalue / (eigenvalue * eigenvalue + aa * ss)) * v * v.transpose();
    }
    if (exact) {
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                H.template block<3, 3>(3 * i, 3 * j) += b.first / c.distance * w[i] * w[j] * rest;
            }
        }
    }
    if (mollified) {
        Vec12 gc;
        Mat12 Hc;
        const Mollifier m = mollify(cloth::cross_squared(x, gc, Hc), c.mollifier);
        const Vec12 gb = b.first * gd;
        H = (m.value * H + m.first * (gc * gb.transpose() + gb * gc.transpose()) +
             (m.second * b.value) * gc * gc.transpose() + (m.first * b.value) * Hc)
                .eval();
        if (kind != HessianKind::exact) {
            const Eigen::SelfAdjointEigenSolver<Mat12> solver(H);
            H = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
                solver.eigenvectors().transpose();
        }
    }
    return H;
}

double BarrierContact::value(const VecX& x) const {
    const auto& list = contacts(x);
    double sum = parallel_sum(static_cast<int>(list.size()), [&](int i) {
        const Contact& c = list[i];
        double e = barrier(c.gap, c.activation, c.stiffness).value;
        if (c.mollifier > 0.0 && e < infinity) {
            e *= mollify(cross_squared(gather(x, c.points)), c.mollifier).value;
        }
        return e;
    });
    for (const Friction& f : friction_) {
        Vec3 u = -f.start;
        for (int i = 0; i < 4; ++i) {
            const int v = f.points[i];
            if (v >= 0 && v < system_.cloth_vertices) u += f.weights[i] * x.segment<3>(3 * v);
        }
        u -= f.normal * f.normal.dot(u);
        sum += f.force * slide(u.norm(), sliding_way_).value;
    }
    return sum;
}

void BarrierContact::add_gradient(const VecX& x, VecX& g) const {
    const int n = system_.cloth_vertices;
    for (const Contact& c : contacts(x)) {
        if (c.flat) {
            g.segment<3>(3 * c.points[0]) += barrier(c.gap, c.activation, c.stiffness).first * c.normal;
            continue;
        }
        const Vec12 gc = contact_gradient(c, gather(x, c.points));
        for (int i = 0; i < 4; ++i) {
            if (c.points[i] < n) g.segment<3>(3 * c.points[i]) += gc.segment<3>(3 * i);
        }
    }
    for (const Friction& f : friction_) {
        Vec3 u = -f.start;
        for (int i = 0; i < 4; ++i) {
            if (f.points[i] >= 0 && f.points[i] < n) u += f.weights[i] * x.segment<3>(3 * f.points[i]);
        }
        u -= f.normal * f.normal.dot(u);
        const double factor = f.force * slide(u.norm(), sliding_way_).slope;
        for (int i = 0; i < 4; ++i) {
            if (f.points[i] >= 0 && f.points[i] < n) {
                g.segment<3>(3 * f.points[i]) += factor * f.weights[i] * u;
            }
        }
    }
}

void BarrierContact::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    ExtraBlocks extra;
    add_hessian(x, kind, kind, H, extra);
    if (!extra.where.empty()) throw std::logic_error("contact couples vertices that the pattern does not");
}

void BarrierContact::add_hessian(const VecX& x, HessianKind kind, HessianKind slides, BlockMatrix& H,
                                 ExtraBlocks& extra) const {
    const int n = system_.cloth_vertices;
    auto moves = [&](int v) { return v >= 0 && v < n; };
    // Blocks of a pair's upper triangle, row by row, and where they go.
    constexpr int nowhere = -2, outside_pattern = -1;
    constexpr std::array<int, 10> rows{0, 0, 0, 0, 1, 1, 1, 2, 2, 3}, columns{0, 1, 2, 3, 1, 2, 3, 2, 3, 3};
    using Slots = std::array<int, 10>;
    auto slots_of = [&](const std::array<int, 4>& points, int split) {
        Slots slots;
        bool coupled_inside = true;
        auto couples = [&](int p) { return rows[p] < split && columns[p] >= split; };
        for (int p = 0; p < 10; ++p) {
            const int v = points[rows[p]], w = points[columns[p]];
            slots[p] = moves(v) && moves(w) ? find_slot(*pattern_, std::min(v, w), std::max(v, w)) : nowhere;
            if (couples(p) && slots[p] == outside_pattern) coupled_inside = false;
        }
        // What the pattern takes of a pair must be positive semi-definite by itself: both sides' own blocks,
        // and those that couple the sides all or none.
        for (int p = 0; p < 10; ++p) {
            if (!coupled_inside && couples(p) && slots[p] != nowhere) slots[p] = outside_pattern;
        }
        return slots;
    };
    const auto& list = contacts(x);
    const int contact_count = static_cast<int>(list.size());
    const int friction_count = static_cast<int>(friction_.size());
    std::vector<Slots> slots(contact_count + friction_count);
    contact_hessians_.resize(contact_count);
    parallel_for(contact_count, [&](int k) {
        const Contact& c = list[k];
        if (c.flat) {
            contact_hessians_[k].topLeftCorner<3, 3>() =
                barrier(c.gap, c.activation, c.stiffness).second * c.normal * c.normal.transpose();
        } else {
            contact_hessians_[k] = contact_hessian(c, gather(x, c.points), kind);
        }
        slots[k] = slots_of(c.points, c.edges ? 2 : 1);
    });
    const double slide_curvature = slides == HessianKind::exact ? 1.0 : 0.8;
    std::vector<Mat3> friction_hessians(friction_count);  // by the way u of the two sides against each other
    parallel_for(friction_count, [&](int k) {
        const Friction& f = friction_[k];
        Vec3 u = -f.start;
        for (int i = 0; i < 4; ++i) {
            if (moves(f.points[i])) u += f.weights[i] * x.segment<3>(3 * f.points[i]);
        }
        u -= f.normal * f.normal.dot(u);
        const Slide s = slide(u.norm(), sliding_way_);
        friction_hessians[k] = f.force * (s.slope * (Mat3::Identity() - f.normal * f.normal.transpose()) +
                                          slide_curvature * s.curvature * u * u.transpose());
        slots[contact_count + k] = slots_of(f.points, f.split);
    });
    auto points_of = [&](int k) -> const std::array<int, 4>& {
        return k < contact_count ? list[k].points : friction_[k - contact_count].points;
    };
    // Block p of pair k, as it stands above the diagonal.
    auto upper = [&](int k, int p) -> Mat3 {
        if (k >= contact_count) {
            const Friction& f = friction_[k - contact_count];
            return f.weights[rows[p]] * f.weights[columns[p]] * friction_hessians[k - contact_count];
        }
        const Mat3 block = contact_hessians_[k].block<3, 3>(3 * rows[p], 3 * columns[p]);
        return list[k].points[rows[p]] <= list[k].points[columns[p]] ? block : Mat3(block.transpose());
    };

    struct Outside {
        std::uint64_t where;  ///< row, column
        int pair, block;
    };
    std::vector<Outside> outside;
    for (int k = 0; k < contact_count + friction_count; ++k) {
        for (int p = 0; p < 10; ++p) {
            const int slot = slots[k][p];
            if (slot >= 0) {
                H.blocks[slot] += upper(k, p);
            } else if (slot == outside_pattern) {
                const auto& points = points_of(k);
                const auto [low, high] = std::minmax(points[rows[p]], points[columns[p]]);
                outside.push_back(
                    {static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high), k, p});
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

void BarrierContact::append_pairs(std::vector<std::array<int, 2>>& pairs) const {
    const int n = system_.cloth_vertices;
    for (const Candidate& c : candidates_) {
        for (int i = 0; i < 4; ++i) {
            for (int j = i + 1; j < 4; ++j) {
                if (c.points[i] < n && c.points[j] < n) pairs.push_back({c.points[i], c.points[j]});
            }
        }
    }
}

// ---------------------------------------------------------------- what is free

double BarrierContact::plane_share(const VecX& x, const VecX& d, bool colliders_move) const {
    double share = 1.0;
    for (std::size_t p = 0; p < system_.planes.size(); ++p) {
        const auto& plane = system_.planes[p];
        if (!on_[plane.collider]) continue;
        const Vec3 n = plane_normals_[p], o = plane_points_[p];
        const Vec3 dn = colliders_move ? Vec3(plane_normal_targets_[p] - n) : Vec3(Vec3::Zero());
        const Vec3 shift = colliders_move ? Vec3(plane_point_targets_[p] - o) : Vec3(Vec3::Zero());
        share = std::min(share, least_share(system_.cloth_vertices, [&](int v) {
                             // Distance a t² + b t + c0; the normal between two unit normals is no longer
                             // than one, so that this understates it. Ends where `slack` of the gap is left.
                             const Vec3 y = x.segment<3>(3 * v) - o, dy = d.segment<3>(3 * v) - shift;
                             const double separation =
                                 plane.radius + system_.mesh.bodies[system_.mesh.vertex_body[v]].radius;
                             const double gap = n.dot(y) - separation;
                             if (!(gap > 0.0)) return 0.0;
                             const double a = dn.dot(dy), b = n.dot(dy) + dn.dot(y), c = (1.0 - slack) * gap;
                             // First t > 0 with a t² + b t + c = 0, c > 0.
                             const double discriminant = b * b - 4.0 * a * c;
                             if (discriminant < 0.0) return 1.0;
                             const double root = std::sqrt(discriminant);
                             // -b + root and -b - root over 2a, written without cancellation.
                             const double q = -0.5 * (b + (b >= 0.0 ? root : -root));
                             double first = 1.0;
                             if (q != 0.0 && c / q > 0.0) first = std::min(first, c / q);
                             if (a != 0.0 && q / a > 0.0) first = std::min(first, q / a);
                             return first;
                         }));
    }
    return share;
}

template <class F>
double BarrierContact::search_share(const VecX& x, const VecX& d, bool colliders_move, const F& pair) const {
    // Along the whole of a long way very many pairs may meet, most of them behind the first impact: look at a
    // short piece first and lengthen it while it is free.
    const Vec3 common = d.reshaped(3, d.size() / 3).rowwise().mean();
    double longest = 0.0;
    for (int v = 0; v < system_.cloth_vertices; ++v) {
        longest = std::max(longest, (d.segment<3>(3 * v) - common).norm());
    }
    double piece = std::min(1.0, first_piece * system_.activation / longest);
    if (colliders_move || !(longest > 0.0)) piece = 1.0;
    for (;; piece = std::min(1.0, 4.0 * piece)) {
        cover(x, piece * d, colliders_move);
        const double share = least_share(static_cast<int>(candidates_.size()),
                                         [&](int i) { return pair(candidates_[i], piece); });
        if (share < 1.0 || piece == 1.0) return share * piece;
    }
}

double BarrierContact::largest_share(const VecX& x, const VecX& d) const {
    const int n = system_.cloth_vertices;
    const double share = search_share(x, d, false, [&](const Candidate& k, double piece) {
        FourPoints motion;
        for (int p = 0; p < 4; ++p) {
            motion[p] = k.points[p] < n ? Vec3(piece * d.segment<3>(3 * k.points[p])) : Vec3(Vec3::Zero());
        }
        return safe_step(k.kind, gather(x, k.points), motion, k.offset, slack);
    });
    return std::min(share, plane_share(x, d, false));
}

double BarrierContact::largest_share_placing(const VecX& x, const VecX& d) const {
    const int n = system_.cloth_vertices;
    const double share = search_share(x, d, true, [&](const Candidate& k, double) {
        FourPoints motion;
        for (int p = 0; p < 4; ++p) {
            const int v = k.points[p];
            motion[p] =
                v < n ? Vec3(d.segment<3>(3 * v))
                      : Vec3(collider_target_.segment<3>(3 * (v - n)) - colliders_.segment<3>(3 * (v - n)));
        }
        return safe_step(k.kind, gather(x, k.points), motion, k.offset, slack);
    });
    return std::min(share, plane_share(x, d, true));
}

void BarrierContact::add_placing_gradient(const VecX& x, VecX& g) const {
    if (placed()) return;
    const int n = system_.cloth_vertices;
    for (const Contact& c : contacts(x)) {
        if (c.collider < 0) continue;
        if (c.flat) {
            for (std::size_t p = 0; p < system_.planes.size(); ++p) {
                if (system_.planes[p].collider != c.collider) continue;
                const Vec3 y = x.segment<3>(3 * c.points[0]) - plane_points_[p];
                const double closing = (plane_normal_targets_[p] - plane_normals_[p]).dot(y) -
                                       c.normal.dot(plane_point_targets_[p] - plane_points_[p]);
                g.segment<3>(3 * c.points[0]) +=
                    barrier(c.gap, c.activation, c.stiffness).second * closing * c.normal;
            }
            continue;
        }
        Vec12 way = Vec12::Zero();
        for (int i = 0; i < 4; ++i) {
            const int v = c.points[i] - n;
            if (v >= 0) {
                way.segment<3>(3 * i) = collider_target_.segment<3>(3 * v) - colliders_.segment<3>(3 * v);
            }
        }
        const Vec12 change = contact_hessian(c, gather(x, c.points), HessianKind::projected) * way;
        for (int i = 0; i < 4; ++i) {
            if (c.points[i] < n) g.segment<3>(3 * c.points[i]) += change.segment<3>(3 * i);
        }
    }
}

VecX BarrierContact::truncated(const VecX& x, const VecX& d) const {
    cover(x, d, false);
    const int n = system_.cloth_vertices;
    std::vector<double> shares(n, 1.0);
    VecX way = d;
    std::vector<double> found(candidates_.size());
    for (int round = 0; round < 4; ++round) {
        parallel_for(static_cast<int>(candidates_.size()), [&](int i) {
            const Candidate& k = candidates_[i];
            const FourPoints p = gather(x, k.points);
            FourPoints motion;
            for (int j = 0; j < 4; ++j) {
                motion[j] = k.points[j] < n ? Vec3(way.segment<3>(3 * k.points[j])) : Vec3(Vec3::Zero());
            }
            const double gap = std::sqrt(nearest(k.kind, p).distance_squared) - k.offset;
            found[i] = safe_step(k.kind, p, motion, k.offset + 0.5 * std::min(gap, k.activation), slack);
        });
        bool changed = false;
        for (std::size_t i = 0; i < candidates_.size(); ++i) {
            if (found[i] >= 1.0) continue;
            changed = true;
            for (int v : candidates_[i].points) {
                if (v < n) shares[v] = std::min(shares[v], found[i]);
            }
        }
        for (std::size_t p = 0; p < system_.planes.size(); ++p) {
            if (!on_[system_.planes[p].collider]) continue;
            for (int v = 0; v < n; ++v) {
                const double gap = plane_normals_[p].dot(x.segment<3>(3 * v) - plane_points_[p]) -
                                   system_.planes[p].radius -
                                   system_.mesh.bodies[system_.mesh.vertex_body[v]].radius;
                const double closing = -plane_normals_[p].dot(way.segment<3>(3 * v));
                const double room = gap - 0.5 * std::min(gap, system_.activation);
                if (closing > room) shares[v] = std::min(shares[v], room / closing);
            }
        }
        for (int v = 0; v < n; ++v) {
            if (shares[v] == 1.0) continue;
            way.segment<3>(3 * v) *= shares[v];
            shares[v] = 1.0;
        }
        if (!changed) break;
    }
    return largest_share(x, way) * way;
}

// ---------------------------------------------------------------- what to report

int BarrierContact::contact_count(const VecX& x) const {
    return static_cast<int>(contacts(x).size());
}

double BarrierContact::smallest_gap(const VecX& x) const {
    double least = system_.activation;
    for (const Contact& c : contacts(x)) least = std::min(least, c.gap);
    return least;
}

std::vector<Overlap> BarrierContact::overlaps(const VecX& x, std::size_t most) const {
    std::vector<Overlap> found;
    const auto& mesh = system_.mesh;
    std::vector<MovingBox> boxes(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        boxes[v].start.add(point(x, v));
        boxes[v].end = boxes[v].start;
    }
    for (const auto& [f, g] : broad_phase_.face_pairs(mesh, boxes, body_on_)) {
        if (found.size() >= most) return found;
        const auto &a = mesh.faces[f], &b = mesh.faces[g];
        if (!triangles_cross({point(x, a[0]), point(x, a[1]), point(x, a[2])},
                             {point(x, b[0]), point(x, b[1]), point(x, b[2])})) {
            continue;
        }
        Overlap o;
        o.faces = {f, g};
        o.body_a = mesh.vertex_body[a[0]];
        o.body_b = mesh.vertex_body[b[0]];
        for (const auto& face : {a, b})
            o.corners.push_back({point(x, face[0]), point(x, face[1]), point(x, face[2])});
        found.push_back(o);
    }
    for (const Contact& c : contacts(x)) {
        if (found.size() >= most) return found;
        if (c.gap > 0.0) continue;
        Overlap o;
        o.points = c.points;
        o.gap = c.gap;
        o.body_a = mesh.vertex_body[c.points[0]];
        if (c.flat) {
            for (std::size_t p = 0; p < system_.planes.size(); ++p) {
                if (system_.planes[p].collider == c.collider) o.body_b = -1 - static_cast<int>(p);
            }
        } else {
            o.body_b = mesh.vertex_body[c.points[c.edges ? 2 : 1]];
        }
        found.push_back(o);
    }
    return found;
}

}  // namespace cloth
