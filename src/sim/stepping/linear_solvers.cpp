#include "sim/stepping/linear_solvers.h"

#include "base/stopwatch.h"

namespace cloth {

void multiply(const BlockPattern& pattern, const SystemMatrix& A, const VecX& x, VecX& y) {
    multiply(pattern, A.inside, x, y);
    A.outside.add_product(x, y);
}

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
    single_.emplace(pattern_, pinned, SparseSolver::Precision::single);
    full_.reset();
}

SparseSolver& ConjugateGradients::full() {
    if (!full_) full_.emplace(pattern_, pinned_);
    return *full_;
}

void ConjugateGradients::zero_pinned(VecX& v) const {
    for (int i : pinned_) v.segment<3>(3 * i).setZero();
}

bool ConjugateGradients::factorize(const SystemMatrix& A, bool semidefinite, StepReport& report) {
    const TimedScope watch(report.contact_times.factorization);
    ++report.factorizations;
    A_ = &A;
    semidefinite_ = semidefinite;
    factor_ = single_serves_ ? &*single_ : &full();
    if (factor_->factorize(A.inside)) return true;
    if (!single_serves_ || !semidefinite) return false;
    single_serves_ = false;
    factor_ = &full();
    return factor_->factorize(A.inside);
}

bool ConjugateGradients::solve(const VecX& b, double tolerance, VecX& d, StepReport& report) {
    d.setZero(b.size());
    Outcome outcome = iterate(b, tolerance, d, report);
    if (outcome == Outcome::slow && single_serves_) {
        single_serves_ = false;
        if (!factorize(*A_, semidefinite_, report)) return false;
        outcome = iterate(b, tolerance, d, report);
    }
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
