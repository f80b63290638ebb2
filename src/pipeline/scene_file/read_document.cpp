// Reads a scene file into its entries.

#include "pipeline/scene_file/document.h"
#include "pipeline/scene_file/fabric_list.h"
#include "pipeline/scene_file/reader.h"
#include "sim/scene/fabrics.h"

namespace cloth::pipeline {
namespace {

Fabric named_fabric(Reader& reader, const toml::node& name, const std::string& key) {
    if (!name.is_string()) reader.fail(key, "is " + type_name(name) + "; must be a fabric's name");
    const std::string text = *name.value<std::string>();
    if (const NamedFabric* found = find_fabric(text)) return found->fabric;
    reader.fail(key, unknown_fabric(text));
}

/// fabric = "cotton", or a table, which may have a base = "cotton".
void read_fabric(Reader& reader, const toml::node& node, const std::string& key, ClothEntry& cloth) {
    Fabric& f = cloth.desc.fabric;
    if (node.is_string()) {
        f = named_fabric(reader, node, key);
        return;
    }
    if (!node.is_table()) {
        reader.fail(key, "is " + type_name(node) + "; must be a fabric's name or a table");
    }
    const toml::table& table = *node.as_table();
    if (table.contains("base")) f = named_fabric(reader, *table.get("base"), key + ".base");
    reader.read(table, key, cloth.fabric_fields(), {"base"});
    // What the table changes leaves parts of its base without a meaning.
    const auto drop = [&](const char* name, auto& value) {
        if (!table.contains(name)) value.reset();
    };
    if (f.mu || f.lambda || f.membrane != MembraneKind::st_venant_kirchhoff) {
        drop("young_weft", f.young_weft);
        drop("shear_modulus", f.shear_modulus);
    }
    if (table.contains("bending") || table.contains("bending_weft")) drop("bending_bias", f.bending_bias);
    if (f.bending_model != BendingKind::hinges) drop("yield_curvature", f.yield_curvature);
    for (const char* name : {"young_modulus", "poisson_ratio"}) {
        if (table.contains(name) && (f.mu || f.lambda)) {
            reader.fail(key + "." + name,
                        "stands beside mu and lambda, which take its place; give one or the other");
        }
    }
}

}  // namespace

void read_document(Reader& reader, Document& d) {
    const std::vector<std::string> tables{"simulation", "air",        "cloth",  "collider", "pin",
                                          "seam",       "drag",       "event",  "camera",   "light",
                                          "ground",     "background", "output", "expect"};
    reader.read(reader.root(), "", d.top_fields(), tables);
    if (!reader.root().contains("version")) reader.fail("version", "is missing; write version = 1");
    if (d.version != 1) reader.fail("version", fmt::format("is {}; this program reads version 1", d.version));

    if (const auto* t = reader.table("simulation")) reader.read(*t, "simulation", d.simulation_fields());
    if (const auto* t = reader.table("air")) reader.read(*t, "air", d.air_fields());
    const auto cloths = reader.list("cloth");
    d.cloths.resize(cloths.size());
    for (std::size_t i = 0; i < cloths.size(); ++i) {
        ClothEntry& c = d.cloths[i];
        c.desc.name = cloths.size() == 1 ? "cloth" : fmt::format("cloth{}", i);
        reader.read(*cloths[i], entry("cloth", i), c.fields(), {"fabric"});
        if (const toml::node* fabric = cloths[i]->get("fabric"))
            read_fabric(reader, *fabric, entry("cloth", i) + ".fabric", c);
    }
    const auto colliders = reader.list("collider");
    d.colliders.resize(colliders.size());
    for (std::size_t i = 0; i < colliders.size(); ++i) {
        d.colliders[i].desc.name = colliders.size() == 1 ? "collider" : fmt::format("collider{}", i);
        reader.read(*colliders[i], entry("collider", i), d.colliders[i].fields());
    }
    const auto pins = reader.list("pin");
    d.pins.resize(pins.size());
    for (std::size_t i = 0; i < pins.size(); ++i) reader.read(*pins[i], entry("pin", i), d.pins[i].fields());
    const auto seams = reader.list("seam");
    d.seams.resize(seams.size());
    for (std::size_t i = 0; i < seams.size(); ++i) {
        const std::string key = entry("seam", i);
        reader.read(*seams[i], key, d.seams[i].fields(), {seam_sides[0], seam_sides[1]});
        for (int side = 0; side < 2; ++side) {
            const std::string side_key = key + "." + seam_sides[side];
            const toml::node* node = seams[i]->get(seam_sides[side]);
            if (!node)
                reader.fail(key, fmt::format("has no {}; give the vertices of both sides", seam_sides[side]));
            if (!node->is_table()) {
                reader.fail(side_key,
                            "is " + type_name(*node) + "; must be a table such as { edge = \"left\" }");
            }
            reader.read(*node->as_table(), side_key, d.seams[i].side_fields(side));
        }
    }
    const auto drags = reader.list("drag");
    d.drags.resize(drags.size());
    for (std::size_t i = 0; i < drags.size(); ++i)
        reader.read(*drags[i], entry("drag", i), d.drags[i].fields());
    const auto events = reader.list("event");
    d.events.resize(events.size());
    for (std::size_t i = 0; i < events.size(); ++i)
        reader.read(*events[i], entry("event", i), d.events[i].fields());
    if (const auto* t = reader.table("camera")) reader.read(*t, "camera", d.camera.fields());
    const auto lights = reader.list("light");
    if (lights.size() > 1) reader.fail("light[1]", "there is one light; a second cannot be given");
    if (!lights.empty()) reader.read(*lights[0], "light[0]", d.light.fields());
    if (const auto* t = reader.table("ground")) {
        d.ground.emplace();
        reader.read(*t, "ground", d.ground->fields());
    }
    if (const auto* t = reader.table("background")) reader.read(*t, "background", d.background.fields());
    if (const auto* t = reader.table("output")) reader.read(*t, "output", d.output_fields());
    if (const auto* t = reader.table("expect")) reader.read(*t, "expect", d.expect_fields());
}

}  // namespace cloth::pipeline
