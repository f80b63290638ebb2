// The direct solver beside CHOLMOD (supernodal, where its package is installed) and Eigen's SimplicialLLT:
// the numeric factorization alone, and a solution with it, of the matrix M + h² H of a cloth with bending,
// bent a little. Not a test.
//
// The program's contestants are best compared in turns:
//
//   bench_solver --benchmark_enable_random_interleaving=true --benchmark_repetitions=9
//
// Arguments: vertices along a side; threads (this project's solver alone uses more than one: CHOLMOD's
// threads are those of its BLAS).

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/SparseCholesky>
#ifdef CLOTH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

#include "sim/algebra/sparse_solver.h"
#include "sim/model.h"
#include "support/sparse.h"

namespace {

using namespace cloth;

/// A square metre of cotton, 1/60 s a step.
struct System {
    explicit System(int side) {
        Scene scene;
        ClothDesc cloth;
        cloth.grid.resolution = {side, side};
        cloth.grid.diagonals = Diagonals::alternating;
        cloth.fabric = {.density = 0.15, .thickness = 5e-4, .young_modulus = 1e6, .bending = 1e-5};
        scene.cloths.push_back(cloth);
        const Model model = build_model(scene);
        VecX x = start_state(model).positions;
        for (int i = 0; i < x.size(); i += 3)
            x(i + 2) += 0.02 * std::sin(9.0 * x(i)) * std::cos(7.0 * x(i + 1));
        const double h = 1.0 / 60.0;
        pattern = model.pattern;
        A.reset(pattern);
        for (const auto& energy : model.energies) energy->add_hessian(x, HessianKind::projected, A);
        for (std::size_t s = 0; s < A.blocks.size(); ++s) {
            A.blocks[s] *= h * h;
            A.blocks[s].diagonal().array() += model.mass.values[s];
        }
        b = VecX::LinSpaced(x.size(), -1.0, 2.0);
        lower = testing::lower_triangle(pattern, A);
    }
    BlockPattern pattern;
    BlockMatrix A;
    VecX b;
    Eigen::SparseMatrix<double> lower;
};

template <SparseSolver::Precision precision>
void this_solver(benchmark::State& state, bool solution) {
    const System system(static_cast<int>(state.range(0)));
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(state.range(1)));
    SparseSolver solver(system.pattern, {}, precision);
    solver.factorize(system.A);
    VecX x;
    for (auto _ : state) {
        if (solution) {
            solver.solve(system.b, x);
        } else if (!solver.factorize(system.A)) {
            state.SkipWithError("not positive definite");
        }
    }
    state.counters["Mflop"] = 1e-6 * solver.statistics().flops;
    state.counters["Mentries"] = 1e-6 * solver.statistics().entries;
}

template <class Solver>
void library(benchmark::State& state, bool solution) {
    const System system(static_cast<int>(state.range(0)));
    Solver solver;
    solver.analyzePattern(system.lower);
    solver.factorize(system.lower);
    VecX x;
    for (auto _ : state) {
        if (solution) {
            x = solver.solve(system.b);
        } else {
            solver.factorize(system.lower);
        }
        if (solver.info() != Eigen::Success) state.SkipWithError("not positive definite");
    }
}

template <class Function>
void add(const char* name, const Function& function, std::vector<std::int64_t> threads) {
    for (const bool solution : {false, true}) {
        const std::string full_name = std::string(solution ? "solve/" : "factorize/") + name;
        benchmark::RegisterBenchmark(full_name.c_str(), function, solution)
            ->ArgsProduct({{20, 40, 100}, threads})
            ->ArgNames({"side", "threads"})
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    }
}

}  // namespace

int main(int argc, char** argv) {
    using Sparse = Eigen::SparseMatrix<double>;
    add("this", this_solver<SparseSolver::Precision::full>, {1, 2});
    add("this_single", this_solver<SparseSolver::Precision::single>, {1, 2});
    add("simplicial", library<Eigen::SimplicialLLT<Sparse>>, {1});
#ifdef CLOTH_CHOLMOD
    add("cholmod", library<Eigen::CholmodSupernodalLLT<Sparse>>, {1});
#endif
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
}
