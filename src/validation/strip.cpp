#include "validation/strip.h"

#include <cmath>
#include <stdexcept>

#include "sim/stepping/total_energy.h"

namespace cloth::validation {

Scene contact_free_scene() {
    Scene scene;
    scene.simulation.contact = ContactKind::velocity_filter;  // of colliders, and there are none
    scene.simulation.accuracy = Accuracy::reference;
    return scene;
}

MeshData make_strip(const std::vector<double>& columns, double width, int across, const Vec3& side) {
    const int nx = static_cast<int>(columns.size()), ny = across + 1;
    MeshData mesh;
    mesh.positions.resize(nx * ny, 3);
    for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i) {
            const Vec3 p =
                columns[i] * Vec3::UnitX() + width * (static_cast<double>(j) / across - 0.5) * side;
            mesh.positions.row(j * nx + i) = p;
        }
    }
    mesh.triangles.resize(2 * (nx - 1) * across, 3);
    int t = 0;
    for (int j = 0; j < across; ++j) {
        for (int i = 0; i + 1 < nx; ++i) {
            const int a = j * nx + i, b = a + 1, c = a + nx, d = c + 1;
            mesh.triangles.row(t++) << a, b, c;
            mesh.triangles.row(t++) << b, d, c;
        }
    }
    return mesh;
}

std::vector<double> even_columns(double length, int count) {
    std::vector<double> x;
    for (int i = 0; i <= count; ++i) x.push_back(length * i / count);
    return x;
}

std::vector<double> clamped_columns(double length, int count, double grading) {
    std::vector<double> cells;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        cells.push_back(std::pow(grading, static_cast<double>(i) / (count - 1)));
        sum += cells.back();
    }
    const double scale = length / (sum - 0.5 * cells[0]);
    std::vector<double> x{-0.5 * cells[0] * scale};
    for (double cell : cells) x.push_back(x.back() + cell * scale);
    return x;
}

std::vector<int> column_vertices(int columns, int rows, int first, int last) {
    std::vector<int> vertices;
    for (int j = 0; j < rows; ++j) {
        for (int i = first; i <= last; ++i) vertices.push_back(j * columns + i);
    }
    return vertices;
}

Vec3 column_position(const Simulation& simulation, int columns, int rows, int column) {
    Vec3 mean = Vec3::Zero();
    for (int v : column_vertices(columns, rows, column, column)) {
        mean += simulation.state().positions.segment<3>(3 * v) / rows;
    }
    return mean;
}

void run_frame(Simulation& simulation) {
    const FrameReport report = simulation.advance_frame();
    if (!report.converged)
        throw std::runtime_error("a step did not converge: residual " + std::to_string(report.residual));
}

int settle(Simulation& simulation, double still, int most) {
    int quiet = 0;
    for (int frame = 1; frame <= most; ++frame) {
        run_frame(simulation);
        quiet = kinetic_energy(simulation.model(), simulation.state()) < still ? quiet + 1 : 0;
        if (quiet == 3) return frame;
    }
    return most;
}

double mean_period(const std::vector<double>& signal, double dt) {
    double first = -1.0, last = -1.0;
    int crossings = 0;
    for (std::size_t i = 1; i < signal.size(); ++i) {
        if (!(signal[i - 1] < 0.0 && signal[i] >= 0.0)) continue;
        last = dt * (static_cast<double>(i - 1) + signal[i - 1] / (signal[i - 1] - signal[i]));
        if (crossings++ == 0) first = last;
    }
    return crossings < 2 ? 0.0 : (last - first) / (crossings - 1);
}

}  // namespace cloth::validation
