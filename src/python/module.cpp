// The Python module's core: scenes, simulations, pictures and kept runs as NumPy arrays. What is Python of it
// is in render_cloth/ beside this file.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/picture/picture.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/report.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/raster/rasterizer.h"
#include "sim/simulation.h"

namespace py = pybind11;

namespace cloth::python {
namespace {

using StatePointer = std::shared_ptr<const State>;

/// A view of numbers that `owner` keeps alive; read-only, so that no state changes behind a simulation's
/// back.
template <class T, class Owner>
py::array_t<T> view_of(const std::shared_ptr<Owner>& owner, const T* numbers,
                       std::vector<py::ssize_t> shape) {
    auto* kept = new std::shared_ptr<const void>(owner);
    const py::capsule base(kept,
                           [](void* pointer) { delete static_cast<std::shared_ptr<const void>*>(pointer); });
    py::array_t<T> array(std::move(shape), numbers, base);
    array.attr("flags").attr("writeable") = false;
    return array;
}

py::array_t<double> rows_of(const StatePointer& state, const VecX& numbers) {
    return view_of(state, numbers.data(), {numbers.size() / 3, 3});
}

VecX flat(const py::array_t<double, py::array::c_style | py::array::forcecast>& rows, Eigen::Index size,
          const char* what) {
    if (rows.ndim() != 2 || rows.shape(1) != 3 || rows.size() != size)
        throw std::invalid_argument(std::string(what) + " needs the shape (" + std::to_string(size / 3) +
                                    ", 3)");
    VecX numbers = Eigen::Map<const VecX>(rows.data(), rows.size());
    if (!numbers.allFinite())
        throw std::invalid_argument(std::string(what) + " has a number that is not finite");
    return numbers;
}

py::dict dict_of(const StepReport& report) {
    py::dict all;
    StepReport::describe(
        [&](const char* name, auto member, const char*, auto) { all[name] = report.*member; });
    return all;
}

/// A simulation whose states are handed out: each is copied once, and lives as long as any array of it.
class PySimulation {
  public:
    PySimulation(std::shared_ptr<const pipeline::SceneFile> scene, int threads)
        : scene_(std::move(scene)), simulation_(scene_->scene, threads) {
        take();
    }

    const std::shared_ptr<const pipeline::SceneFile>& scene() const { return scene_; }
    const Model& model() const { return simulation_.model(); }
    const StatePointer& state() const { return state_; }

    py::dict step() {
        StepReport report;
        {
            const py::gil_scoped_release released;
            report = simulation_.step();
            take();
        }
        return dict_of(report);
    }
    py::dict advance() {
        FrameReport report;
        {
            const py::gil_scoped_release released;
            report = simulation_.advance_frame();
            take();
        }
        py::dict all = dict_of(report);
        all["frame"] = report.frame;
        return all;
    }
    void restore(const State& state) {
        simulation_.restore(state);
        take();
    }
    void set(const py::array_t<double, py::array::c_style | py::array::forcecast>& rows, VecX State::*member,
             const char* what) {
        State changed = simulation_.state();
        changed.*member = flat(rows, changed.positions.size(), what);
        restore(changed);
    }
    void hold(const std::vector<int>& vertices, const Points& places) { simulation_.hold(vertices, places); }
    void release(const std::vector<int>& vertices) { simulation_.release(vertices); }

  private:
    void take() { state_ = std::make_shared<const State>(simulation_.state()); }

    std::shared_ptr<const pipeline::SceneFile> scene_;
    Simulation simulation_;
    StatePointer state_;
};

/// Draws states of one scene.
class PyRenderer {
  public:
    PyRenderer(std::shared_ptr<const pipeline::SceneFile> scene, int threads)
        : scene_(std::move(scene)),
          model_(build_model(scene_->scene)),
          rasterizer_(threads, render::GlLibrary::automatic) {}

    py::array_t<std::uint8_t> draw(const State& state) {
        if (state.positions.size() != 3 * model_.vertex_count())
            throw std::invalid_argument("the state has " + std::to_string(state.positions.size() / 3) +
                                        " vertices, the renderer's scene " +
                                        std::to_string(model_.vertex_count()));
        auto image = std::make_shared<render::Image>();
        {
            const py::gil_scoped_release released;
            pipeline::SceneFile file = *scene_;
            file.annotation.curves.clear();  // of a whole run, which is not here
            file.annotation.motion_blur = 1;
            pipeline::RunFacts facts = pipeline::facts_of(file);
            if (file.camera.framing == pipeline::Framing::automatic) {
                pipeline::Extent extent(file.camera, static_cast<double>(file.view.width) / file.view.height);
                for (int v = 0; v < model_.vertex_count(); ++v) extent.add(state.positions.segment<3>(3 * v));
                facts.extent = extent;
            }
            if (file.annotation.shade && !facts.shade) {
                const VecX values = VertexFields(model_).at(*file.annotation.shade, state);
                facts.shade =
                    pipeline::shade_range(*file.annotation.shade, {values.begin(), values.end()}, 1.0);
            }
            *image = pipeline::PictureMaker(file, model_, facts, rasterizer_).draw(state);
        }
        return view_of(image, image->rgba.data(), {image->height, image->width, 4});
    }

  private:
    std::shared_ptr<const pipeline::SceneFile> scene_;
    Model model_;
    render::Rasterizer rasterizer_;
};

/// A run's folder.
class PyRun {
  public:
    explicit PyRun(const std::filesystem::path& folder)
        : run_(pipeline::open_run(folder)), read_(pipeline::state_reader(run_.folder, run_.model)) {}

    std::vector<std::int64_t> frames() const { return run_.folder.kept_states(); }
    std::shared_ptr<const pipeline::SceneFile> scene() const {
        return std::make_shared<const pipeline::SceneFile>(run_.file);
    }
    StatePointer state(std::int64_t frame) const {
        return std::make_shared<const State>(pipeline::read_kept(read_, frame));
    }
    std::string certificate() const { return pipeline::read_file(run_.folder.certificate()); }
    std::string report() const { return pipeline::read_file(run_.folder.report()); }
    py::array_t<int> triangles() const {
        const auto& t = run_.model.triangles;
        return py::array_t<int>({t.rows(), Eigen::Index{3}}, t.data());
    }

  private:
    pipeline::KeptRun run_;
    pipeline::StateReader read_;
};

/// Energies of a state, by name [J], of what a step minimises and does not depend on it.
std::map<std::string, double> energies_of(const PySimulation& simulation) {
    std::map<std::string, double> all;
    for (const auto& energy : simulation.model().energies)
        all[std::string(energy->name())] += energy->value(simulation.state()->positions);
    return all;
}

py::array_t<double> gradient_of(const PySimulation& simulation) {
    auto g = std::make_shared<VecX>(VecX::Zero(simulation.state()->positions.size()));
    for (const auto& energy : simulation.model().energies)
        energy->add_gradient(simulation.state()->positions, *g);
    return view_of(g, g->data(), {g->size() / 3, 3});
}

/// Rows, columns and values of the exact Hessian, both triangles of it.
py::tuple hessian_of(const PySimulation& simulation) {
    const Model& model = simulation.model();
    BlockMatrix H;
    H.reset(model.pattern);
    for (const auto& energy : model.energies)
        energy->add_hessian(simulation.state()->positions, HessianKind::exact, H);
    std::vector<int> rows, columns;
    std::vector<double> values;
    for (int i = 0; i < model.pattern.vertex_count(); ++i) {
        for (int s = model.pattern.row_begin[i]; s < model.pattern.row_begin[i + 1]; ++s) {
            const int j = model.pattern.column[s];
            for (int a = 0; a < 3; ++a) {
                for (int b = 0; b < 3; ++b) {
                    const double value = H.blocks[s](a, b);
                    rows.push_back(3 * i + a);
                    columns.push_back(3 * j + b);
                    values.push_back(value);
                    if (i == j) continue;
                    rows.push_back(3 * j + b);
                    columns.push_back(3 * i + a);
                    values.push_back(value);
                }
            }
        }
    }
    return py::make_tuple(py::array(py::cast(rows)), py::array(py::cast(columns)),
                          py::array(py::cast(values)));
}

}  // namespace

PYBIND11_MODULE(_core, m) {
    m.doc() = "Cloth simulation and its pictures; see render_cloth";
    static py::exception<pipeline::Error> error(m, "Error", PyExc_RuntimeError);
    error.attr("__doc__") =
        "What the program would refuse or fail with, in its own words; `code` is its exit code.";
    py::register_exception_translator([](std::exception_ptr thrown) {
        const auto raise = [](const std::string& message, pipeline::ExitCode code) {
            py::object value = py::reinterpret_borrow<py::object>(error.ptr())(message);
            value.attr("code") = static_cast<int>(code);
            PyErr_SetObject(error.ptr(), value.ptr());
        };
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const pipeline::Error& e) {
            raise(e.what(), e.code);
        } catch (const SceneError& e) {
            raise(e.key + ": " + e.what(), pipeline::ExitCode::invalid_scene);
        }
    });
    m.attr("version") = pipeline::program_version();
    m.attr("build") = pipeline::build_fingerprint();

    py::class_<pipeline::SceneFile, std::shared_ptr<pipeline::SceneFile>>(m, "Scene",
                                                                          "A scene, as load() reads it.")
        .def_readonly("name", &pipeline::SceneFile::name)
        .def_readonly("description", &pipeline::SceneFile::description)
        .def_readonly("notes", &pipeline::SceneFile::notes,
                      "What should be known of how it was read, a text each.")
        .def_property_readonly("frames", [](const pipeline::SceneFile& s) { return s.output.frames; })
        .def_property_readonly(
            "frame_rate", [](const pipeline::SceneFile& s) { return s.scene.simulation.frame_rate; },
            "Frames per second of simulated time.")
        .def_property_readonly(
            "toml", [](const pipeline::SceneFile& s) { return s.resolved(); },
            "The scene file with every default written out.");
    m.def("_load", [](const std::string& name, const std::vector<std::string>& settings) {
        pipeline::Overrides overrides(settings.begin(), settings.end());
        return std::make_shared<pipeline::SceneFile>(pipeline::load_scene(name, overrides));
    });
    m.def("scenes", &pipeline::list_scenes, "Name and description of every scene that comes along.");

    py::class_<State, std::shared_ptr<State>>(
        m, "State", "All that changes in a simulation; restore() resumes it exactly.")
        .def_readonly("time", &State::time, "[s]")
        .def_readonly("frame", &State::frame)
        .def_property_readonly(
            "positions", [](const std::shared_ptr<State>& s) { return rows_of(s, s->positions); },
            "Shape (n, 3) [m], read-only; no copy.")
        .def_property_readonly(
            "velocities", [](const std::shared_ptr<State>& s) { return rows_of(s, s->velocities); },
            "Shape (n, 3) [m/s], read-only; no copy.");

    py::class_<PySimulation>(m, "Simulation", "Advances a scene. While it computes other Python threads run.")
        .def(py::init([](std::shared_ptr<pipeline::SceneFile> scene, int threads) {
                 return std::make_unique<PySimulation>(std::move(scene), threads);
             }),
             py::arg("scene"), py::arg("threads") = 0,
             "threads: 0 for all cores; states do not depend on it.")
        .def("step", &PySimulation::step, "One time step; its report as a dict.")
        .def("advance", &PySimulation::advance, "The steps of one frame; their report as a dict.")
        .def("restore", &PySimulation::restore, py::arg("state"), "Goes on from a state of this scene.")
        .def("hold", &PySimulation::hold, py::arg("vertices"), py::arg("places"),
             "Holds vertices: within the next frame each goes straight to its place, shape (k, 3) [m], and "
             "stays.")
        .def("release", &PySimulation::release, py::arg("vertices") = std::vector<int>(),
             "Lets held vertices go; all of them where none is named.")
        .def_property_readonly(
            "state", [](const PySimulation& s) { return std::const_pointer_cast<State>(s.state()); })
        .def_property_readonly(
            "time", [](const PySimulation& s) { return s.state()->time; }, "[s]")
        .def_property_readonly("frame", [](const PySimulation& s) { return s.state()->frame; })
        .def_property(
            "positions", [](const PySimulation& s) { return rows_of(s.state(), s.state()->positions); },
            [](PySimulation& s, const py::array_t<double, py::array::c_style | py::array::forcecast>& x) {
                s.set(x, &State::positions, "positions");
            },
            "Shape (n, 3) [m]; a read-only view of the state, no copy. Assigning sets them.")
        .def_property(
            "velocities", [](const PySimulation& s) { return rows_of(s.state(), s.state()->velocities); },
            [](PySimulation& s, const py::array_t<double, py::array::c_style | py::array::forcecast>& v) {
                s.set(v, &State::velocities, "velocities");
            },
            "Shape (n, 3) [m/s]; a read-only view of the state, no copy. Assigning sets them.")
        .def_property_readonly(
            "triangles",
            [](const PySimulation& s) {
                const Triangles& t = s.model().triangles;
                return py::array_t<int>({t.rows(), Eigen::Index{3}}, t.data());
            },
            "Corners of all triangles, shape (m, 3).")
        .def_property_readonly(
            "masses", [](const PySimulation& s) { return VecX(s.model().vertex_mass); },
            "Of the vertices, shape (n) [kg].")
        .def_property_readonly(
            "pinned", [](const PySimulation& s) { return s.model().pinned; },
            "Vertices that the scene's pins hold at the start.")
        .def("energies", &energies_of, "Of the state, by name [J]: membrane, bending, gravity ...")
        .def("gradient", &gradient_of, "Of their sum by the positions, shape (n, 3) [N].")
        .def("_hessian", &hessian_of);

    py::class_<PyRenderer>(m, "Renderer", "Draws states of a scene as its pictures show them.")
        .def(py::init([](std::shared_ptr<pipeline::SceneFile> scene, int threads) {
                 return std::make_unique<PyRenderer>(std::move(scene), threads);
             }),
             py::arg("scene"), py::arg("threads") = 0)
        .def(
            "draw", [](PyRenderer& r, const std::shared_ptr<State>& state) { return r.draw(*state); },
            py::arg("state"), "The picture, uint8 of shape (height, width, 4): red, green, blue, opacity.");

    py::class_<PyRun>(m, "_Run")
        .def(py::init<const std::string&>())
        .def_property_readonly("frames", &PyRun::frames)
        .def_property_readonly(
            "scene", [](const PyRun& r) { return std::const_pointer_cast<pipeline::SceneFile>(r.scene()); })
        .def_property_readonly("triangles", &PyRun::triangles)
        .def("state", [](const PyRun& r,
                         std::int64_t frame) { return std::const_pointer_cast<State>(r.state(frame)); })
        .def("_certificate", &PyRun::certificate)
        .def("_report", &PyRun::report);
}

}  // namespace cloth::python
