#include "pipeline/scene_file/read_scene.h"

#include "pipeline/formats/arcsim_fabric.h"
#include "pipeline/scene_file/fabric_list.h"
#include "pipeline/scene_file/picture_schema.h"
#include "pipeline/scene_file/tables.h"
#include "sim/scene/fabrics.h"

namespace cloth::pipeline {
namespace {

/// Visitor: makes as many entries of each list as the file has, and the tables that a scene may leave out.
struct Entries {
    Reader& reader;

    template <class... Key>
    void operator()(Key&&...) {}
    template <class... S>
    void table(const char* name, S&...) {
        reader.table(name);
    }
    template <class S>
    void table(const char* name, std::optional<S>& desc) {
        if (reader.table(name)) desc.emplace();
    }
    template <class... S>
    void list(const char* name, std::vector<S>&... descs) {
        const std::size_t count = reader.list(name).size();
        (descs.resize(count), ...);
    }
    template <class S>
    void one_of_a_list(const char* name, S&) {
        if (reader.list(name).size() > 1)
            reader.fail(entry(name, 1), fmt::format("there is one {}; a second cannot be given", name));
    }
};

/// "cloth", or "cloth0", "cloth1" … where there are several.
template <class Desc>
void number_names(std::vector<Desc>& descs) {
    if (descs.size() < 2) return;
    for (std::size_t i = 0; i < descs.size(); ++i) descs[i].name += std::to_string(i);
}

Fabric named_fabric(Reader& reader, SceneFile& file, const toml::node& name, const std::string& key) {
    if (!name.is_string())
        reader.fail(key, "is " + type_name(name) + "; must be a fabric's name, or the name of its file");
    const std::string text = *name.value<std::string>();
    if (text.ends_with(".json")) {
        const std::filesystem::path path = reader.find_file(text);
        try {
            LoadedFabric loaded = read_arcsim_fabric(path);
            for (const std::string& note : loaded.notes)
                file.notes.push_back(fmt::format("{}: {}: {}", key, path.string(), note));
            return loaded.fabric;
        } catch (const std::runtime_error& error) {
            reader.fail(key, error.what());
        }
    }
    if (const NamedFabric* found = find_fabric(text)) return found->fabric;
    reader.fail(key, unknown_fabric(text));
}

/// fabric = "cotton" or "measured.json", or a table, which begins with such a base or with the struct's
/// values.
void read_fabric(Reader& reader, SceneFile& file, const toml::node& node, const Table& at, Fabric& f) {
    if (node.is_string()) {
        f = named_fabric(reader, file, node, at.path);
        return;
    }
    if (!node.is_table()) {
        reader.fail(at.path, "is " + type_name(node) + "; must be a fabric's name or a table");
    }
    const toml::table& table = *node.as_table();
    f = table.contains("base") ? named_fabric(reader, file, *table.get("base"), at.path + ".base") : Fabric{};
    reader.read(table, at.path, at.fields, {"base"});
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
            reader.fail(at.path + "." + name,
                        "stands beside mu and lambda, which take its place; give one or the other");
        }
    }
}

/// Keys of a table that are tables themselves.
std::vector<std::string> nested_in(const Table& table, const Tables& tables) {
    std::vector<std::string> keys;
    if (table.name.empty()) {
        for (const RootTable& t : root_tables()) keys.push_back(t.name);
        return keys;
    }
    for (const Table& t : tables) {
        if (t.path == table.path + "." + t.key()) keys.push_back(t.key());
    }
    return keys;
}

}  // namespace

void read_scene(Reader& reader, SceneFile& file) {
    const toml::table& root = reader.root();
    Entries entries{reader};
    describe(entries, file);
    number_names(file.scene.cloths);
    number_names(file.scene.colliders);

    std::size_t cloth = 0, part = 0;
    const Tables tables = tables_of(file, file.files);
    for (const Table& table : tables) {
        const toml::node* node = table.path.empty() ? &root : reader.find(table.path);
        if (table.name == "cloth.fabric" || table.name == "part.fabric") {
            Fabric& fabric = table.name.starts_with("cloth") ? file.scene.cloths[cloth++].fabric
                                                             : file.scene.parts[part++].fabric;
            if (node) read_fabric(reader, file, *node, table, fabric);
            continue;
        }
        if (table.name.starts_with("seam.")) {
            if (!node)
                reader.fail(table.path.substr(0, table.path.rfind('.')),
                            fmt::format("has no {}; give the vertices of both sides", table.key()));
            if (!node->is_table())
                reader.fail(table.path,
                            "is " + type_name(*node) + "; must be a table such as { edge = \"left\" }");
        }
        if (node) reader.read(*node->as_table(), table.path, table.fields, nested_in(table, tables));
        if (!table.path.empty()) continue;
        if (!root.contains("version")) reader.fail("version", "is missing; write version = 1");
        if (file.version != 1)
            reader.fail("version", fmt::format("is {}; this program reads version 1", file.version));
    }
}

}  // namespace cloth::pipeline
