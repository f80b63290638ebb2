#pragma once
// Keys of what a run makes: equal where it would be the same bits.

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"

namespace cloth::pipeline {

/// Of all that a scene says.
std::string scene_key(const SceneFile& file);

/// The part of a scene that decides states, events apart: the rest is as if nothing were said.
SceneFile physics_of(const SceneFile& file);
/// The part that decides a picture beside its state.
SceneFile look_of(const SceneFile& file);

/// A run that goes on where another was: the keys of its frames up to the one where it leaves the other.
struct Trunk {
    std::vector<std::string> keys;
    bool empty() const { return keys.empty(); }
};

/// Key k is that of the state of frame k: made from the build, the scene's physics and the events that act up
/// to it, each by the one before. Those of a trunk are its own.
std::vector<std::string> state_keys(const SceneFile& file, const Model& model, std::int64_t frames,
                                    const Trunk& trunk);

/// Of the state that a branch begins with, which was `key` in the run that it leaves.
std::string branch_key(const SceneFile& file, const std::string& key);

/// How many of the model's events (sorted by time) have acted when frame `frame` is reached.
std::uint32_t events_before(const Model& model, std::int64_t frame);

/// Key of each picture of a run with these states. Pictures that know of the whole run depend on all of them.
std::vector<std::string> picture_keys(const SceneFile& file, const std::vector<std::string>& states,
                                      std::int64_t frames);

/// Of a movie of the first `frames` pictures.
std::string movie_key(const SceneFile& file, const std::vector<std::string>& pictures, std::int64_t frames,
                      double playback_rate);

}  // namespace cloth::pipeline
