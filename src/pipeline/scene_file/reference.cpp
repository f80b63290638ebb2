// Tells of every key of a scene file.

#include "pipeline/scene_file/document.h"

namespace cloth::pipeline {

std::string key_reference() {
    Document d;
    ClothEntry cloth;
    cloth.size = cloth.desc.grid.size;
    cloth.resolution = Resolution{cloth.desc.grid.resolution};
    cloth.diagonals = cloth.desc.grid.diagonals;
    ColliderEntry collider;
    PinEntry pin;
    SeamEntry seam;
    DragEntry drag;
    EventEntry event;
    GroundEntry ground;
    std::string text;
    auto table = [&](const std::string& title, const Fields& fields) {
        text += (text.empty() ? "" : "\n") + title + "\n";
        for (const Field& f : fields) {
            std::string kind = f.type;
            // The unit of a choice is the list of its names.
            const bool names = f.type == "one of" || f.type == "list of";
            if (!f.range.empty()) kind += ", " + f.range;
            if (!f.unit.empty()) kind += names ? " " + f.unit : " [" + f.unit + "]";
            const std::string value = f.write();
            std::string help = f.help;
            if (!value.empty() && value != "\"\"") {
                help += (help.empty() ? "default " : "; default ") + value;
            } else if (help.find("default") == help.npos) {
                help += help.empty() ? "none by default" : "; none by default";
            }
            // A long kind gets a line of its own.
            const bool wide = kind.size() > 26;
            text += fmt::format("  {:<18} {:<26}", f.key, kind);
            text += (wide ? fmt::format("\n  {:<18} {:<26} ", "", "") : " ") + help + "\n";
        }
    };
    table("(top of the file)", d.top_fields());
    table("[simulation]", d.simulation_fields());
    table("[air]", d.air_fields());
    table("[[cloth]]", cloth.fields());
    table("[cloth.fabric]  (or fabric = \"cotton\"; base = \"cotton\" begins with its values)",
          cloth.fabric_fields());
    table("[[collider]]", collider.fields());
    table("[[pin]]", pin.fields());
    table("[[seam]]", seam.fields());
    table("[seam.first], [seam.second]", seam.side_fields(0));
    table("[[drag]]", drag.fields());
    table("[[event]]", event.fields());
    table("[camera]", d.camera.fields());
    table("[[light]]", d.light.fields());
    table("[ground]  (no table: the first level plane that stands still is drawn so, or no floor)",
          ground.fields());
    table("[background]", d.background.fields());
    table("[output]", d.output_fields());
    table("[expect]", d.expect_fields());
    return text;
}

}  // namespace cloth::pipeline
