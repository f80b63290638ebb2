#include "sim/stepping/contact_solver.h"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "sim/stepping/line_search.h"

namespace cloth {
namespace {

class Minimization {
  public:
    Minimization(const ContactProblem& problem, SparseSolver& solver, ContactWorkspace& w, StepReport& report)
        : p_(problem),
          solver_(solver),
          w_(w),
          report_(report),
          times_(report.contact_times),
          h2_(problem.h * problem.h) {}

    bool run(VecX& x) {
        const SimulationDesc& options = p_.model.scene.simulation;
        const double scale = std::max(gradient(x), 1e-2 * p_.model.weight);
        report_.placed = place(x);
        if (!report_.placed) return false;
        double value = objective(x);
        {
            const TimedScope watch(times_.detection);
            w_.trial = x + p_.contact.truncated(x, way_to_guess(x));
        }
        if (const double guess = objective(w_.trial); guess < value) {
            x = w_.trial;
            value = guess;
        }
        double norm = gradient(x);
        const double extent = x.cwiseAbs().maxCoeff();
        bool converged = norm <= options.newton_tolerance * scale;
        for (int k = 0; !converged && k < options.newton_iterations; ++k) {
            if (!direction(x, norm, scale)) break;
            ++report_.iterations;
            converged = w_.direction.cwiseAbs().maxCoeff() < 1e-14 * extent;
            if (converged) break;
            slow_ = w_.direction.cwiseAbs().maxCoeff() < options.newton_speed * p_.h;
            const double slope = -w_.rhs.dot(w_.direction) / h2_;
            const double rounding = 1e-13 * (std::abs(value) + p_.model.weight * extent);
            w_.start = x;
            if (!search_line(
                    w_.start, w_.direction, largest_share(x, w_.direction), slope, rounding, norm,
                    [&](const VecX& at) { return objective(at); },
                    [&](const VecX& at) { return gradient(at); }, x, value)) {
                break;
            }
            norm = gradient(x);
            converged = norm <= options.newton_tolerance * scale ||
                        (slow_ && net_speed() < balance * options.newton_speed);
        }
        norm = gradient(x);
        report_.residual = scale > 0.0 ? norm / scale : 0.0;
        if (!converged) report_.worst_vertex = worst_vertex(w_.rhs);
        return converged;
    }

  private:
    double objective(const VecX& at) {
        const TimedScope watch(times_.evaluation);
        w_.residual = at - p_.y;
        multiply(p_.model.pattern, p_.model.mass, w_.residual, w_.momentum);
        double value = 0.5 / h2_ * w_.residual.dot(w_.momentum);
        if (p_.force.size() > 0) value -= p_.force.dot(at);
        value += p_.potential.value(at);
        return value + p_.contact.value(at);
    }

    /// Leaves -h² ∇Φ of the free vertices in rhs; gives |∇Φ|.
    double gradient(const VecX& at) {
        const TimedScope watch(times_.evaluation);
        w_.gradient.setZero(at.size());
        p_.potential.gradient(at, w_.gradient);
        p_.contact.add_gradient(at, w_.gradient);
        if (p_.force.size() > 0) w_.gradient -= p_.force;
        w_.residual = at - p_.y;
        multiply(p_.model.pattern, p_.model.mass, w_.residual, w_.momentum);
        w_.rhs = -(w_.momentum + h2_ * w_.gradient);
        zero_pinned(p_.pins, w_.rhs);
        return w_.rhs.norm() / h2_;
    }

    /// Greatest of the cloths: change of its mean velocity by the force that is left in rhs [m/s].
    double net_speed() const {
        double greatest = 0.0;
        for (const ClothRange& cloth : p_.model.cloths) {
            const int first = cloth.first_vertex, count = cloth.vertex_count;
            const Vec3 sum = w_.rhs.segment(3 * first, 3 * count).reshaped(3, count).rowwise().sum();
            const double mass = p_.model.vertex_mass.segment(first, count).sum();
            greatest = std::max(greatest, sum.norm() / (mass * p_.h));
        }
        return greatest;
    }

    void assemble(const VecX& x, HessianKind kind, HessianKind slides = HessianKind::projected) {
        const TimedScope watch(times_.assembly);
        w_.system.reset(p_.model.pattern);
        p_.potential.hessian(x, kind, w_.system);
        p_.contact.add_hessian(x, HessianKind::projected, slides, w_.system, w_.extra);
        for (std::size_t s = 0; s < w_.system.blocks.size(); ++s) {
            w_.system.blocks[s] *= h2_;
            w_.system.blocks[s].diagonal().array() += p_.model.mass.values[s];
        }
        for (Mat3& block : w_.extra.blocks) block *= h2_;
    }

    /// In single precision while that serves: as a preconditioner it is as good and takes half the time.
    bool factorize(bool semidefinite) {
        const TimedScope watch(times_.factorization);
        ++report_.factorizations;
        factor_ = single_ ? &*w_.single : &solver_;
        if (factor_->factorize(w_.system)) return true;
        if (!single_ || !semidefinite) return false;
        single_ = false;
        factor_ = &solver_;
        return factor_->factorize(w_.system);
    }

    double largest_share(const VecX& x, const VecX& d) const {
        const TimedScope watch(times_.detection);
        return p_.contact.largest_share(x, d);
    }

    void apply(const VecX& v, VecX& out) {
        multiply(p_.model.pattern, w_.system, v, out);
        w_.extra.add_product(v, out);
        zero_pinned(p_.pins, out);
    }

    enum class Cg { converged, slow, indefinite };

    /// Conjugate gradients on A d = rhs from the d given, until the error's energy norm, as the factor sees
    /// it, is `tolerance` of what it is at d = 0. In the residual's own norm one stiff contact would hide the
    /// rest.
    Cg conjugate_gradients(double tolerance, int most) {
        const TimedScope watch(times_.solution);
        VecX &d = w_.direction, &r = w_.residual, &z = w_.preconditioned, &q = w_.conjugate;
        apply(d, r);
        r = w_.rhs - r;
        zero_pinned(p_.pins, r);
        const bool from_zero = d.isZero(0.0);
        double rz = 0.0;
        for (int k = 0;; ++k) {
            factor_->solve(r, z);
            zero_pinned(p_.pins, z);
            const double rz_new = r.dot(z);
            if (k == 0 && from_zero) rz_at_zero_ = rz_new;
            if (rz_new <= tolerance * tolerance * rz_at_zero_) return Cg::converged;
            if (k == most) return Cg::slow;
            ++report_.cg_iterations;
            if (k == 0) {
                q = z;
            } else {
                q = z + rz_new / rz * q;
            }
            rz = rz_new;
            apply(q, w_.product);
            const double curvature = q.dot(w_.product);
            if (!(curvature > 0.0)) return Cg::indefinite;
            const double length = rz / curvature;
            d += length * q;
            r -= length * w_.product;
        }
    }

    /// Newton direction for -h²∇Φ in rhs. Far from the minimum by the projected Hessian: the exact one is
    /// mostly indefinite there, and no better where it is not. Near it by as large a share of the exact one
    /// as is positive definite.
    bool direction(const VecX& x, double norm, double scale) {
        const bool near = norm < 1e-2 * scale;
        const HessianKind slides = near || slow_ ? HessianKind::exact : HessianKind::projected;
        const double tolerance = std::clamp(0.03 * norm / scale, 1e-4, 0.03);
        for (double exact : {1.0, 0.9, 0.6, 0.0}) {
            if (exact > 0.0 && !near) continue;
            if (exact == 1.0) {
                assemble(x, HessianKind::exact, slides);
                w_.exact = w_.system;
            } else if (exact == 0.9 || !near) {
                assemble(x, HessianKind::projected, slides);
                if (near) w_.projected = w_.system;
            }
            if (near && exact < 1.0) {
                for (std::size_t s = 0; s < w_.system.blocks.size(); ++s) {
                    w_.system.blocks[s] = exact * w_.exact.blocks[s] + (1.0 - exact) * w_.projected.blocks[s];
                }
            }
            w_.direction.setZero(x.size());
            if (!factorize(exact == 0.0)) continue;
            Cg cg = conjugate_gradients(tolerance, most_cg);
            if (cg == Cg::slow && single_) {
                single_ = false;
                if (!factorize(exact == 0.0)) continue;
                cg = conjugate_gradients(tolerance, most_cg);
            }
            if (cg == Cg::indefinite) continue;
            if (w_.rhs.dot(w_.direction) > 0.0) return true;
        }
        return false;
    }

    /// Where inertia and gravity would take x, with the pins where they go.
    VecX way_to_guess(const VecX& x) const {
        VecX way = p_.y - x;
        const Vec3 fall = h2_ * p_.model.scene.simulation.gravity;
        way.reshaped(3, way.size() / 3).colwise() += fall;
        set_pinned_way(p_.pins, x, way);
        return way;
    }

    /// Takes pins and colliders to the stage's end.
    bool place(VecX& x) {
        if (p_.contact.placed() && pins_placed(p_.pins, x)) return true;
        const VecX free_way = way_to_guess(x);
        if (share_placing(x, free_way) == 1.0) {
            const VecX before = x;
            x += free_way;
            place_pinned(p_.pins, x);
            if (std::isfinite(p_.potential.value(x))) {
                p_.contact.place(1.0);
                return true;
            }
            x = before;
        }
        constexpr int most_placements = 60;
        for (int k = 0; k < most_placements; ++k) {
            ++report_.placements;
            gradient(x);
            w_.gradient.setZero();
            p_.contact.add_placing_gradient(x, w_.gradient);
            w_.rhs -= h2_ * w_.gradient;
            assemble(x, HessianKind::projected);
            VecX pin_way = VecX::Zero(x.size());
            set_pinned_way(p_.pins, x, pin_way);
            multiply(p_.model.pattern, w_.system, pin_way, w_.product);
            w_.extra.add_product(pin_way, w_.product);
            w_.rhs -= w_.product;
            zero_pinned(p_.pins, w_.rhs);
            if (!factorize(true)) return false;
            w_.direction.setZero(x.size());
            if (conjugate_gradients(1e-2, most_cg) == Cg::indefinite) return false;
            VecX way = w_.direction;
            set_pinned_way(p_.pins, x, way);
            double share = share_placing(x, way);
            const VecX start = x;
            x = start + share * way;
            for (int halvings = 0; !std::isfinite(p_.potential.value(x)); ++halvings) {
                if (halvings == 30) return false;
                share *= 0.5;
                x = start + share * way;
            }
            p_.contact.place(share);
            if (share == 1.0) {
                place_pinned(p_.pins, x);
                return true;
            }
        }
        return false;
    }

    double share_placing(const VecX& x, const VecX& d) const {
        const TimedScope watch(times_.detection);
        return p_.contact.largest_share_placing(x, d);
    }

    static constexpr double balance = 0.01;  // net speed left, against newton_speed
    static constexpr int most_cg = 200;

    const ContactProblem& p_;
    SparseSolver& solver_;
    ContactWorkspace& w_;
    StepReport& report_;
    ContactTimes& times_;
    double h2_;
    SparseSolver* factor_ = nullptr;
    bool single_ = true;  ///< single precision has served so far
    bool slow_ = false;   ///< the last step was slower than newton_speed
    double rz_at_zero_ = 0.0;
};

}  // namespace

StepReport minimize_with_contact(const ContactProblem& problem, SparseSolver& solver, VecX& x,
                                 ContactWorkspace& w) {
    StepReport report;
    report.converged = Minimization(problem, solver, w, report).run(x);
    return report;
}

}  // namespace cloth
