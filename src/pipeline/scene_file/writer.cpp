// Writes a scene as TOML.

#include "pipeline/scene_file/document.h"

namespace cloth::pipeline {
namespace {

std::string write_fields(const Fields& fields) {
    std::string text;
    for (const Field& f : fields) {
        const std::string value = f.write();
        if (!value.empty()) text += f.key + " = " + value + "\n";
    }
    return text;
}

}  // namespace

std::string write_document(Document& d) {
    std::string text = write_fields(d.top_fields());
    text += "\n[simulation]\n" + write_fields(d.simulation_fields());
    text += "\n[air]\n" + write_fields(d.air_fields());
    for (ClothEntry& c : d.cloths) {
        text += "\n[[cloth]]\n" + write_fields(c.fields()) + "\n[cloth.fabric]\n" +
                write_fields(c.fabric_fields());
    }
    for (ColliderEntry& c : d.colliders) text += "\n[[collider]]\n" + write_fields(c.fields());
    for (PinEntry& p : d.pins) text += "\n[[pin]]\n" + write_fields(p.fields());
    for (SeamEntry& s : d.seams) {
        text += "\n[[seam]]\n" + write_fields(s.fields());
        for (int side = 0; side < 2; ++side)
            text += fmt::format("\n[seam.{}]\n", seam_sides[side]) + write_fields(s.side_fields(side));
    }
    for (DragEntry& drag : d.drags) text += "\n[[drag]]\n" + write_fields(drag.fields());
    for (EventEntry& e : d.events) text += "\n[[event]]\n" + write_fields(e.fields());
    text += "\n[camera]\n" + write_fields(d.camera.fields());
    text += "\n[[light]]\n" + write_fields(d.light.fields());
    if (d.ground) text += "\n[ground]\n" + write_fields(d.ground->fields());
    text += "\n[background]\n" + write_fields(d.background.fields());
    text += "\n[output]\n" + write_fields(d.output_fields());
    text += "\n[expect]\n" + write_fields(d.expect_fields());
    return text;
}

}  // namespace cloth::pipeline
