#include "sim/simulation.h"

#include <algorithm>
#include <stdexcept>

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "sim/stepping/advance.h"

namespace cloth {

struct Simulation::Impl {
    Impl(const Scene& scene, int threads)
        // More threads than cores would only make oneTBB print a warning.
        : arena(threads > 0 ? std::min(threads, tbb::info::default_concurrency())
                            : tbb::task_arena::automatic),
          model(build_model(scene)),
          state(start_state(model)),
          workspace(model) {}

    tbb::task_arena arena;
    Model model;
    State state;
    Workspace workspace;
};

Simulation::Simulation(const Scene& scene, int threads) : impl_(std::make_unique<Impl>(scene, threads)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

const Model& Simulation::model() const {
    return impl_->model;
}
const State& Simulation::state() const {
    return impl_->state;
}

void Simulation::restore(const State& state) {
    const State& own = impl_->state;  // the model's sizes, which no step changes
    if (state.positions.size() != own.positions.size() || state.velocities.size() != own.velocities.size() ||
        state.collider_on.size() != own.collider_on.size() || state.drags.size() != own.drags.size() ||
        state.rest_folds.size() != own.rest_folds.size()) {
        throw std::invalid_argument("the state does not belong to this scene: it has " +
                                    std::to_string(state.positions.size() / 3) + " vertices, the scene " +
                                    std::to_string(impl_->model.vertex_count()));
    }
    impl_->state = state;
    impl_->workspace.newton.indefinite = state.indefinite;
}

void Simulation::hold(const std::vector<int>& vertices, const Points& places) {
    if (places.rows() != static_cast<Eigen::Index>(vertices.size()))
        throw std::invalid_argument("hold: " + std::to_string(vertices.size()) + " vertices and " +
                                    std::to_string(places.rows()) + " places; give one each");
    if (!places.allFinite()) throw std::invalid_argument("hold: a place is not finite");
    for (const int v : vertices) {
        if (v < 0 || v >= impl_->model.vertex_count())
            throw std::invalid_argument("hold: vertex " + std::to_string(v) + " does not exist; there are " +
                                        std::to_string(impl_->model.vertex_count()));
    }
    const double now = impl_->state.time, frame = impl_->model.steps_per_frame * impl_->model.time_step;
    release(vertices);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        impl_->workspace.holds.push_back({vertices[i], impl_->state.positions.segment<3>(3 * vertices[i]),
                                          places.row(static_cast<Eigen::Index>(i)), now, now + frame});
}

void Simulation::release(const std::vector<int>& vertices) {
    std::vector<Hold>& holds = impl_->workspace.holds;
    if (vertices.empty()) return holds.clear();
    std::erase_if(holds, [&](const Hold& hold) {
        return std::find(vertices.begin(), vertices.end(), hold.vertex) != vertices.end();
    });
}

void Simulation::stop_on(const std::atomic<bool>* request) {
    impl_->workspace.newton.stop = request;
}

StepReport Simulation::step() {
    const StepReport report =
        impl_->arena.execute([&] { return advance(impl_->model, impl_->state, impl_->workspace); });
    impl_->state.indefinite = impl_->workspace.newton.indefinite;
    return report;
}

FrameReport Simulation::advance_frame() {
    FrameReport frame;
    for (int s = 0; s < impl_->model.steps_per_frame; ++s) {
        merge(frame, step());
        if (!frame.converged) return frame;
    }
    frame.frame = ++impl_->state.frame;
    return frame;
}

}  // namespace cloth
