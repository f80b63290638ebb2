// Writes a scene as TOML, and compares two by what would be written.

#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

/// The tables of a scene that is only read.
Tables tables_of(const SceneFile& file, FileNames& files) {
    return tables_of(const_cast<SceneFile&>(file), files);
}

}  // namespace

std::string SceneFile::resolved(const FileNames& kept) const {
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
