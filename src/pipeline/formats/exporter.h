#pragma once
// What writes meshes of one topology, frame by frame.

#include <cstdint>

#include "pipeline/formats/state_store.h"
#include "sim/scene/scene.h"

namespace cloth::pipeline {

/// begin(), then frame() for each frame in rising order, then end(). Its files appear under their names in
/// end(); one that is destroyed without leaves none. Each call throws Error(other) naming the file that
/// cannot be written, and the cause.
class Exporter {
  public:
    Exporter() = default;
    Exporter(const Exporter&) = delete;
    Exporter& operator=(const Exporter&) = delete;
    virtual ~Exporter() = default;

    /// `frame_rate`: frames per second of simulated time.
    virtual void begin(const Topology& topology, double frame_rate) = 0;
    /// `time` [s], `positions` of shape (n, 3) [m], n as in the topology.
    virtual void frame(std::int64_t index, double time, const Points& positions) = 0;
    virtual void end() = 0;
};

}  // namespace cloth::pipeline
