// Writes a scene as TOML, and compares two by what would be written.

#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

/// The tables of a scene that is only read.
Tables tables_of(const SceneFile& file, FileNames& files) {
    return tables_of(const_cast<SceneFile&>(file), files);
}

/// Whether the scene is written with a mesh that has more vertices than the scene's.
bool other_vertices(const SceneFile& file, const FileNames& kept) {
    for (std::size_t c = 0; c < file.vertices_in_file.size(); ++c) {
        if (!file.vertices_in_file[c].empty() && !kept.contains(entry("cloth", c) + ".mesh")) return true;
    }
    return false;
}

/// Whether the scene is written with a sewing pattern, which brings its seams along.
bool with_pattern(const SceneFile& file, const FileNames& kept) {
    for (std::size_t c = 0; c < file.scene.cloths.size(); ++c) {
        const std::string key = entry("cloth", c) + ".mesh";
        const auto name = file.files.find(key);
        if (name != file.files.end() && name->second.ends_with(".json") && !kept.contains(key)) return true;
    }
    return false;
}

/// `file` with the vertex numbers that its mesh files have.
SceneFile numbered_as_in_files(SceneFile file, const FileNames& kept) {
    const auto number = [&](VertexSelection& selection, int cloth) {
        const auto c = static_cast<std::size_t>(cloth);
        if (file.vertices_in_file[c].empty() || kept.contains(entry("cloth", c) + ".mesh")) return;
        for (int& v : selection.vertices) v = file.vertices_in_file[c].at(static_cast<std::size_t>(v));
    };
    for (PinDesc& pin : file.scene.pins) number(pin, pin.cloth);
    for (SeamDesc& seam : file.scene.seams) {
        for (SeamDesc::Side& side : seam.sides) number(side, side.cloth);
    }
    return file;
}

}  // namespace

std::string SceneFile::resolved(const FileNames& kept) const {
    if (other_vertices(*this, kept)) {
        SceneFile numbered = numbered_as_in_files(*this, kept);
        numbered.vertices_in_file.clear();
        return numbered.resolved(kept);
    }
    if (own_seams < scene.seams.size() && with_pattern(*this, kept)) {
        SceneFile own = *this;
        own.scene.seams.resize(own_seams);
        return own.resolved(kept);
    }
    FileNames names = files;
    for (const auto& [key, as_kept] : kept) names[key] = as_kept;
    std::string text;
    for (const Table& table : tables_of(*this, names)) {
        if (!table.name.empty()) text += "\n" + table.header() + "\n";
        for (const Field& f : table.fields) {
            const std::string value = f.applies ? f.write() : "";
            if (!value.empty()) text += f.key + " = " + value + "\n";
        }
    }
    return text;
}

std::map<std::string, std::string> values_of(const SceneFile& file) {
    FileNames names = file.files;
    std::map<std::string, std::string> values;
    for (const Table& table : tables_of(file, names)) {
        if (!table.path.empty()) values[table.path];
        for (const Field& f : table.fields) {
            if (f.applies)
                values[table.path + (table.path.empty() ? "" : ".") + f.key] =
                    f.content ? f.content() : f.write();
        }
    }
    return values;
}

std::vector<std::string> differences(const SceneFile& a, const SceneFile& b) {
    const auto values_a = values_of(a), values_b = values_of(b);
    std::vector<std::string> keys;
    for (const auto& [key, value] : values_a) {
        const auto other = values_b.find(key);
        if (other == values_b.end() || other->second != value) keys.push_back(key);
    }
    for (const auto& [key, value] : values_b)
        if (!values_a.contains(key)) keys.push_back(key);
    // Of a table that only one of them has, its name says it all.
    std::erase_if(keys, [&](const std::string& key) {
        for (const std::string& table : keys)
            if (key.size() > table.size() && key.starts_with(table) &&
                std::string_view(".").find(key[table.size()]) != std::string_view::npos)
                return true;
        return false;
    });
    return keys;
}

std::string difference(const SceneFile& a, const SceneFile& b) {
    FileNames files_a = a.files, files_b = b.files;
    const Tables tables_a = tables_of(a, files_a), tables_b = tables_of(b, files_b);
    auto other = tables_b.begin();
    for (const Table& table : tables_a) {
        if (other == tables_b.end() || table.path != other->path) return table.path;
        auto g = other->fields.begin();
        for (const Field& f : table.fields) {
            const bool same = f.applies == g->applies &&
                              (f.content ? f.content() == g->content() : f.write() == g->write());
            if (!same) return table.path + (table.path.empty() ? "" : ".") + f.key;
            ++g;
        }
        ++other;
    }
    return other == tables_b.end() ? "" : other->path;
}

}  // namespace cloth::pipeline
