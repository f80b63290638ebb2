#pragma once
// Scenes and strips for the checks, and running them. Internal.

#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/simulation.h"

namespace cloth::validation {

/// A scene whose cloth passes through itself: the checks are of what no contact has a part in.
Scene contact_free_scene();

/// A strip along x: columns of vertices at the given x, `across` cells over the width along `side`.
MeshData make_strip(const std::vector<double>& columns, double width, int across, const Vec3& side);

/// `count` + 1 equal columns from 0 to `length`.
std::vector<double> even_columns(double length, int count);

/// Columns for a strip clamped at x = 0: the first two, held, stand half a cell before and behind it, and the
/// free end at `length`. The last cell is `grading` times as long as the first.
std::vector<double> clamped_columns(double length, int count, double grading);

/// Vertices of the columns first … last of a strip of `columns` columns and `rows` rows.
std::vector<int> column_vertices(int columns, int rows, int first, int last);

/// Mean position of a column.
Vec3 column_position(const Simulation& simulation, int columns, int rows, int column);

/// Steps a frame; throws std::runtime_error where a step does not converge.
void run_frame(Simulation& simulation);

/// Runs frames until the kinetic energy stays below `still` [J] or `most` frames are done.
int settle(Simulation& simulation, double still, int most);

/// Time between zero crossings: the mean period of a signal sampled at steps of `dt`, linear in between; 0
/// where it crosses zero upwards fewer than twice.
double mean_period(const std::vector<double>& signal, double dt);

}  // namespace cloth::validation
