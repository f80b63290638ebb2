#pragma once
// How Newton's method solves A d = b for the free vertices: directly, or by conjugate gradients on a factor.

#include <memory>
#include <optional>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/sparse_solver.h"
#include "sim/stepping/preconditioner.h"
#include "sim/stepping/step_report.h"

namespace cloth {

class LinearSolver {
  public:
    virtual ~LinearSolver() = default;
    /// From now on leaves out these vertices, sorted, and no others.
    virtual void leave_out(const std::vector<int>& pinned) = 0;
    /// Before the solves of one minimisation.
    virtual void begin() {}
    /// False where A is found not to be positive definite. `semidefinite`: it is known to be no less. A must
    /// outlive the solves.
    virtual bool factorize(const SystemMatrix& A, bool semidefinite, StepReport& report) = 0;
    /// d = A⁻¹ b, within `tolerance` where the solver is not exact, and 0 at the vertices left out; false
    /// where A is found not to be positive definite. Requires a successful factorize().
    virtual bool solve(const VecX& b, double tolerance, VecX& d, StepReport& report) = 0;
};

/// By a Cholesky factor. For matrices within the pattern.
class DirectSolver final : public LinearSolver {
  public:
    /// `pattern` must outlive this.
    explicit DirectSolver(const BlockPattern& pattern) : pattern_(pattern) {}
    void leave_out(const std::vector<int>& pinned) override { factor_.emplace(pattern_, pinned); }
    bool factorize(const SystemMatrix& A, bool semidefinite, StepReport& report) override;
    bool solve(const VecX& b, double tolerance, VecX& d, StepReport& report) override;

  private:
    const BlockPattern& pattern_;
    std::optional<SparseSolver> factor_;
};

/// Conjugate gradients on the whole matrix, preconditioned by a factor that costs less than the matrix's own:
/// without bending's second ring, with the blocks that couple cloths in contact where that is cheap enough,
/// and in single precision while that serves. They end where the error's energy norm, as the factor sees it,
/// is `tolerance` of what it is at d = 0: in the residual's own norm one stiff contact would hide the rest.
class ConjugateGradients final : public LinearSolver {
  public:
    /// Of matrices over `pattern`, on factors over `near` and contact. Both must outlive this.
    ConjugateGradients(const BlockPattern& pattern, const BlockPattern& near)
        : pattern_(pattern), near_(near) {}
    void leave_out(const std::vector<int>& pinned) override;
    void begin() override;
    bool factorize(const SystemMatrix& A, bool semidefinite, StepReport& report) override;
    bool solve(const VecX& b, double tolerance, VecX& d, StepReport& report) override;

  private:
    enum class Outcome { converged, slow, indefinite };
    Outcome iterate(const VecX& b, double tolerance, VecX& d, StepReport& report);
    void choose(const SystemMatrix& A);
    Preconditioner& whole();
    void zero_pinned(VecX& v) const;

    const BlockPattern &pattern_, &near_;
    std::vector<int> pinned_;
    std::optional<Preconditioner> single_;   ///< without contact
    std::optional<Preconditioner> coupled_;  ///< with the blocks of contact that were lately asked for
    std::optional<Preconditioner> whole_;    ///< in full precision: made where single has not served
    Preconditioner* factor_ = nullptr;
    const SystemMatrix* A_ = nullptr;
    bool semidefinite_ = false;

    // Since begin():
    bool single_serves_ = true;
    bool couples_ = false;                ///< `coupled_` is worth its cost,
    bool too_dear_ = false;               ///< or was found not to be
    std::optional<int> last_iterations_;  ///< of the last solve

    double rz_at_zero_ = 0.0;
    VecX product_, residual_, preconditioned_, conjugate_;
};

}  // namespace cloth
