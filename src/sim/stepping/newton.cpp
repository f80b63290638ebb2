#include "sim/stepping/newton.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "sim/contact/ccd.h"
#include "sim/stepping/line_search.h"
#include "sim/stepping/obstacle.h"

namespace cloth {
namespace {

class Minimization {
  public:
    Minimization(const NewtonProblem& problem, LinearSolver& solver, NewtonWorkspace& w, StepReport& report)
        : p_(problem),
          solver_(solver),
          w_(w),
          report_(report),
          times_(report.contact_times),
          contact_(problem.terms.contact()),
          barrier_(problem.terms.barrier()),
          h2_(problem.h * problem.h) {
        rule_.limits = p_.model.scene.simulation.stopping();
    }

    bool run(VecX& x) {
        w_.before = x;
        // Where the step begins in balance, the weight sets the scale.
        rule_.scale = std::max(gradient(x), 1e-2 * p_.model.weight);
        if (!std::isfinite(rule_.scale)) {
            report_.obstacle = strain_at(p_.model, x);
            return false;
        }
        report_.placed = place(x);
        if (!report_.placed) {
            report_.obstacle =
                obstacle_of_placing(p_.model, contact_, p_.pins, x, strained_ ? &guess_ : nullptr);
            return false;
        }
        double value = objective(x);
        const auto guess_improves = [&](bool falls) {
            make_first_guess(x, falls);
            const double guess = objective(w_.trial);
            if (!(guess < value)) return false;
            x = w_.trial;
            value = guess;
            return true;
        };
        if (!guess_improves(true) && barrier_) guess_improves(false);
        double norm = gradient(x);
        const double extent = x.cwiseAbs().maxCoeff();
        bool converged = rule_.converged(norm);
        const int most = p_.model.scene.simulation.newton_iterations;
        for (int k = 0; !converged && k < most; ++k) {
            if (w_.stopping() || !find_direction(x, norm)) break;
            ++report_.iterations;
            const double way = w_.direction.cwiseAbs().maxCoeff();
            converged = rule_.lost_in_rounding(norm, stiffness(), way, extent);
            if (converged) break;
            rule_.own = (x - w_.before).norm() / (p_.h * std::sqrt(p_.model.vertex_count()));
            slow_ = rule_.slow(way, p_.h);
            const double slope = -w_.rhs.dot(w_.direction) / h2_;
            const double rounding = 1e-13 * (std::abs(value) + p_.model.weight * extent);
            w_.start = x;
            if (!search_line(
                    w_.start, w_.direction, largest_share(x, w_.direction), slope, rounding, norm,
                    [&](const VecX& at) { return objective(at); },
                    [&](const VecX& at) { return gradient(at); }, x, value)) {
                norm = gradient(x);
                break;
            }
            norm = gradient(x);
            converged = rule_.converged(norm) || (slow_ && rule_.at_rest(net_speed()));
        }
        report_.residual = rule_.scale > 0.0 ? norm / rule_.scale : 0.0;
        if (!converged) {
            report_.worst_vertex = worst_vertex(w_.rhs);
            report_.obstacle = strain_at(p_.model, x);
        }
        return converged;
    }

  private:
    double objective(const VecX& at) {
        const TimedScope watch(times_.evaluation);
        w_.residual = at - p_.y;
        multiply(p_.model.pattern, p_.model.mass, w_.residual, w_.momentum);
        double value = 0.5 / h2_ * w_.residual.dot(w_.momentum);
        if (p_.force.size() > 0) value -= p_.force.dot(at);
        value += p_.terms.value(at);
        if (barrier_) {
            contact_->find(at);
            value += barrier_->value(at);
        }
        return value;
    }

    /// Leaves -h² ∇Φ of the free vertices in rhs; gives |∇Φ|.
    double gradient(const VecX& at) {
        const TimedScope watch(times_.evaluation);
        p_.terms.gradient(at, w_.gradient);
        if (barrier_) {
            contact_->find(at);
            barrier_->add_gradient(at, w_.gradient);
        }
        if (p_.force.size() > 0) w_.gradient -= p_.force;
        w_.residual = at - p_.y;
        multiply(p_.model.pattern, p_.model.mass, w_.residual, w_.momentum);
        w_.rhs = -(w_.momentum + h2_ * w_.gradient);
        zero_pinned(p_.pins, w_.rhs);
        return w_.rhs.norm() / h2_;
    }

    /// M + h² H. Contact's part is always projected; `slides`: that of its friction.
    void assemble(const VecX& x, HessianKind kind, HessianKind slides, BlockMatrix& inside) {
        const TimedScope watch(times_.assembly);
        p_.terms.hessian(x, kind, inside);
        if (barrier_) {
            contact_->find(x);
            barrier_->add_hessian(x, HessianKind::projected, slides, inside, w_.system.outside);
            for (Mat3& block : w_.system.outside.blocks) block *= h2_;
        }
        add_inertia(p_.model, p_.h, inside);
    }

    bool solve(double tolerance, bool semidefinite) {
        return solver_.factorize(w_.system, semidefinite, report_) &&
               solver_.solve(w_.rhs, tolerance, w_.direction, report_) && w_.rhs.dot(w_.direction) > 0.0;
    }

    /// Newton direction for -h²∇Φ in rhs. Among barriers the exact Hessian is mostly indefinite far from the
    /// minimum, and no better where it is not; without them it is looked at there too, until it is found to
    /// be.
    bool find_direction(const VecX& x, double norm) {
        const bool near = rule_.near(norm);
        const HessianKind slides = near || slow_ ? HessianKind::exact : HessianKind::projected;
        // The energy norm of what is left of the direction; more than this and iterations are wasted.
        constexpr double loosest = 0.1, tightest = 1e-4;
        const double tolerance = std::clamp(loosest * norm / rule_.scale, tightest, loosest);
        if (near || (!barrier_ && !w_.indefinite)) {
            assemble(x, HessianKind::exact, slides, w_.system.inside);
            w_.indefinite = !solve(tolerance, false);
            if (!w_.indefinite) return true;
            std::swap(w_.exact, w_.system.inside);
            assemble(x, HessianKind::projected, slides, w_.projected);
            w_.system.inside.blocks.resize(w_.exact.blocks.size());
            for (double share : {0.9, 0.6}) {
                for (std::size_t s = 0; s < w_.exact.blocks.size(); ++s) {
                    w_.system.inside.blocks[s] =
                        share * w_.exact.blocks[s] + (1.0 - share) * w_.projected.blocks[s];
                }
                if (solve(tolerance, false)) return true;
            }
            std::swap(w_.projected, w_.system.inside);
        } else {
            assemble(x, HessianKind::projected, slides, w_.system.inside);
        }
        return solve(tolerance, true);
    }

    /// Root of the sum of the squared diagonal blocks' traces, of the Hessian and M/h² [N/m].
    double stiffness() const {
        double sum = 0.0;
        for (int i = 0; i < p_.model.vertex_count(); ++i) {
            const double trace = w_.system.inside.blocks[p_.model.pattern.diagonal(i)].trace();
            sum += trace * trace;
        }
        return std::sqrt(sum) / h2_;
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

    /// Where inertia and, where it `falls`, gravity would take x, with the pins where they go.
    VecX way_to_guess(const VecX& x, bool falls) const {
        VecX way = p_.y - x;
        const Vec3 fall = h2_ * p_.model.scene.simulation.gravity;
        if (falls) way.reshaped(3, way.size() / 3).colwise() += fall;
        set_pinned_way(p_.pins, x, way);
        return way;
    }

    /// Leaves it in trial; without barriers it is y, whether it falls or not.
    void make_first_guess(const VecX& x, bool falls) {
        if (!barrier_) {
            w_.trial = p_.y;
            place_pinned(p_.pins, w_.trial);
            return;
        }
        const TimedScope watch(times_.detection);
        w_.trial = x + truncated_way(*contact_, x, way_to_guess(x, falls));
    }

    /// Takes pins and colliders to the stage's end.
    bool place(VecX& x) {
        if ((!barrier_ || contact_->placed()) && pins_placed(p_.pins, x)) return true;
        if (place_at_once(x)) return true;
        constexpr int most_placements = 60, most_idle = 5;
        constexpr double idle_share = 1e-3;  // what moves this little at a time has come to its end
        for (int k = 0, idle = 0; k < most_placements && idle < most_idle; ++k) {
            if (w_.stopping()) return false;
            ++report_.placements;
            gradient(x);
            if (barrier_) {
                w_.gradient.setZero();
                barrier_->add_placing_gradient(x, w_.gradient);
                w_.rhs -= h2_ * w_.gradient;
            }
            assemble(x, HessianKind::projected, HessianKind::projected, w_.system.inside);
            VecX way = VecX::Zero(x.size());
            set_pinned_way(p_.pins, x, way);
            multiply(p_.model.pattern, w_.system, way, w_.product);
            w_.rhs -= w_.product;
            zero_pinned(p_.pins, w_.rhs);
            if (!solver_.factorize(w_.system, true, report_)) return false;
            if (!solver_.solve(w_.rhs, 1e-2, w_.direction, report_)) return false;
            way = w_.direction;
            set_pinned_way(p_.pins, x, way);
            double share = largest_share_placing(x, way);
            w_.start = x;
            x = w_.start + share * way;
            if (k == 0) guess_ = x + way;
            for (int halvings = 0; !std::isfinite(p_.terms.value(x)); ++halvings) {
                strained_ = true;
                share *= 0.5;
                x = w_.start + share * way;
                if (halvings == 30) return false;
            }
            idle = share < idle_share ? idle + 1 : 0;
            if (barrier_) contact_->place(share);
            if (share == 1.0) {
                place_pinned(p_.pins, x);
                return true;
            }
        }
        return false;
    }

    /// By the first guess as a whole; false, and x as it was, where the way there is not free.
    bool place_at_once(VecX& x) {
        if (barrier_) {
            const VecX way = way_to_guess(x, true);
            if (largest_share_placing(x, way) < 1.0) return false;
            w_.trial = x + way;
            place_pinned(p_.pins, w_.trial);
        } else {
            make_first_guess(x, true);
        }
        if (!std::isfinite(p_.terms.value(w_.trial))) return false;
        x = w_.trial;
        if (barrier_) contact_->place(1.0);
        return true;
    }

    double largest_share(const VecX& x, const VecX& d) const {
        if (!barrier_) return 1.0;
        const TimedScope watch(times_.detection);
        return cloth::largest_share(*contact_, x, d);
    }

    double largest_share_placing(const VecX& x, const VecX& d) const {
        if (!barrier_) return 1.0;
        const TimedScope watch(times_.detection);
        return cloth::largest_share_placing(*contact_, x, d);
    }

    const NewtonProblem& p_;
    LinearSolver& solver_;
    NewtonWorkspace& w_;
    StepReport& report_;
    ContactTimes& times_;
    ContactSet* contact_;            ///< null: no barriers
    const BarrierContact* barrier_;  ///< null: none
    double h2_;
    StoppingRule rule_;
    bool slow_ = false;      ///< the last step was
    VecX guess_;             ///< where the first placing would have taken the cloth, shape (3n) [m]
    bool strained_ = false;  ///< a strain limit shortened the placing
};

}  // namespace

StepReport minimize(const NewtonProblem& problem, LinearSolver& solver, NewtonWorkspace& workspace, VecX& x) {
    StepReport report;
    solver.begin();
    report.converged = Minimization(problem, solver, workspace, report).run(x);
    if (const ContactSet* contact = problem.terms.contact(); contact && report.converged) {
        report.contacts = contact_count(*contact, x);
        report.smallest_gap = smallest_gap(*contact, x);
    }
    return report;
}

void add_inertia(const Model& model, double h, BlockMatrix& A) {
    parallel_for(static_cast<int>(A.blocks.size()), [&](int s) {
        A.blocks[s] *= h * h;
        A.blocks[s].diagonal().array() += model.mass.values[s];
    });
}

}  // namespace cloth
