// A sheet falls onto a ball; its last frame becomes falling_sheet.png. Built against an installed
// render_cloth:
//   cmake -B build && cmake --build build && build/falling_sheet
#include <iostream>

#include "pipeline/picture/picture.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/simulation.h"

int main() {
    const auto file = cloth::pipeline::parse_scene(R"(
        version = 1
        [[cloth]]
        resolution = 16
        rotate = [-90.0, 0.0, 0.0]
        translate = [0.0, 0.3, 0.0]
        [[collider]]
    )",
                                                   "falling_sheet.toml", ".");

    cloth::Simulation simulation(file.scene);
    for (int frame = 1; frame <= 12; ++frame) {
        const cloth::FrameReport report = simulation.advance_frame();
        if (!report.converged) return 1;
    }
    const cloth::VecX& q = simulation.state().positions;
    std::cout << "vertex 0 stands at " << q.head<3>().transpose() << " m\n";

    cloth::render::Rasterizer rasterizer;
    cloth::pipeline::PictureMaker pictures(file, simulation.model(), cloth::pipeline::facts_of(file),
                                           rasterizer);
    cloth::render::write_png(pictures.draw(simulation.state()), "falling_sheet.png");
}
