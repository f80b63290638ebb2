#include "sim/stepping/linear_solvers.h"

#include <algorithm>
#include <utility>

#include "base/stopwatch.h"

namespace cloth {

bool DirectSolver::factorize(const SystemMatrix& A, bool, StepReport& report) {
    const TimedScope watch(report.contact_times.factorization);
    ++report.factorizations;
    return factor_->factorize(A.inside);
}

bool DirectSolver::solve(const VecX& b, double, VecX& d, StepReport& report) {
    const TimedScope watch(report.contact_times.solution);
    factor_->solve(b, d);
    return true;
}

void ConjugateGradients::leave_out(const std::vector<int>& pinned) {
    pinned_ = pinned;
    single_.emplace(pattern_, near_, pinned, SparseSolver::Precision::single);
    coupled_.reset();
    whole_.reset();
}

void ConjugateGradients::begin() {
    single_serves_ = true;
    couples_ = too_dear_ = false;
    last_iterations_.reset();
}

Preconditioner& ConjugateGradients::whole() {
    if (!whole_) whole_.emplace(pattern_, pattern_, pinned_, SparseSolver::Precision::full);
    return *whole_;
}

void ConjugateGradients::zero_pinned(VecX& v) const {
    for (int i : pinned_) v.segment<3>(3 * i).setZero();
}

/// Whether contact is coupled in the factor: where that costs less than the iterations that it saves. Costs
/// are counted, not timed, so that they are the same everywhere.
void ConjugateGradients::choose(const SystemMatrix& A) {
    // A solve with contact coupled takes about `few` iterations; one without, before any was seen, `typical`.
    // After more than `many` something is missing in the factor.
    constexpr int few = 4, typical = 16, many = 8;
    // An iteration reads each entry of the factor twice, and memory is slower than arithmetic.
    constexpr double flops_per_entry = 24.0;
    const std::optional<int> last = std::exchange(last_iterations_, std::nullopt);
    if (A.outside.where.empty()) {
        couples_ = false;
        return;
    }
    if (too_dear_ || (last && *last <= many)) return;
    if (!coupled_ || coupled_->contacts() != A.outside.where) {
        coupled_.emplace(pattern_, near_, pinned_, SparseSolver::Precision::single, A.outside.where);
    }
    auto cost = [](const Preconditioner& p, int iterations) {
        return p.statistics().flops + flops_per_entry * p.statistics().entries * iterations;
    };
    couples_ = cost(*coupled_, few) < cost(*single_, std::max(last.value_or(0), typical));
    too_dear_ = !couples_;
}

bool ConjugateGradients::factorize(const SystemMatrix& A, bool semidefinite, StepReport& report) {
    const TimedScope watch(report.contact_times.factorization);
    ++report.factorizations;
    A_ = &A;
    semidefinite_ = semidefinite;
    if (single_serves_) {
        choose(A);
        factor_ = couples_ ? &*coupled_ : &*single_;
    } else {
        factor_ = &whole();
    }
    if (factor_->factorize(A)) return true;
    if (!single_serves_ || !semidefinite) return false;
    single_serves_ = false;
    factor_ = &whole();
    return factor_->factorize(A);
}

bool ConjugateGradients::solve(const VecX& b, double tolerance, VecX& d, StepReport& report) {
    d.setZero(b.size());
    const int before = report.cg_iterations;
    Outcome outcome = iterate(b, tolerance, d, report);
    if (outcome == Outcome::slow && single_serves_) {
        single_serves_ = false;
        if (!factorize(*A_, semidefinite_, report)) return false;
        outcome = iterate(b, tolerance, d, report);
    }
    last_iterations_ = report.cg_iterations - before;
    return outcome != Outcome::indefinite;
}

/// From the d given on.
ConjugateGradients::Outcome ConjugateGradients::iterate(const VecX& b, double tolerance, VecX& d,
                                                        StepReport& report) {
    constexpr int most = 200;
    const TimedScope watch(report.contact_times.solution);
    VecX &r = residual_, &z = preconditioned_, &q = conjugate_;
    auto apply = [&](const VecX& v, VecX& out) {
        multiply(pattern_, *A_, v, out);
        zero_pinned(out);
    };
    apply(d, r);
    r = b - r;
    zero_pinned(r);
    const bool from_zero = d.isZero(0.0);
    double rz = 0.0;
    for (int k = 0;; ++k) {
        factor_->solve(r, z);
        zero_pinned(z);
        const double rz_new = r.dot(z);
        if (k == 0 && from_zero) rz_at_zero_ = rz_new;
        if (rz_new <= tolerance * tolerance * rz_at_zero_) return Outcome::converged;
        if (k == most) return Outcome::slow;
        ++report.cg_iterations;
        if (k == 0) {
            q = z;
        } else {
            q = z + rz_new / rz * q;
        }
        rz = rz_new;
        apply(q, product_);
        const double curvature = q.dot(product_);
        if (!(curvature > 0.0)) return Outcome::indefinite;
        const double length = rz / curvature;
        d += length * q;
        r -= length * product_;
    }
}

}  // namespace cloth
