// Tells of every key of a scene file.

#include <algorithm>

#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

std::string title(const Table& table) {
    if (table.name.empty()) return "(top of the file)";
    if (table.name == "cloth.fabric")
        return "[cloth.fabric]  (no table: " + default_fabric().name +
               "; fabric = \"silk\": that; base = \"silk\" begins with its values, else with these)";
    if (table.name == "seam.first") return "[seam.first], [seam.second]";
    if (table.name == "ground")
        return "[ground]  (no table: the first level plane that stands still is drawn so, or no floor)";
    return table.header();
}

/// Characters of UTF-8 text.
std::ptrdiff_t width(const std::string& text) {
    return std::count_if(text.begin(), text.end(),
                         [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; });
}

std::string line(const Field& f) {
    std::string kind = f.words;
    if (!f.range.empty()) kind += ", " + f.range;
    kind += unit_suffix(f);
    std::string help = f.meaning;
    const std::string value = f.applies ? f.write() : "";
    if (!value.empty() && value != "\"\"") {
        help += (help.empty() ? "default " : "; default ") + value;
    } else if (help.find("default") == help.npos) {
        help += help.empty() ? "none by default" : "; none by default";
    }
    // A long kind gets a line of its own.
    const std::string gap = width(kind) > 26 ? fmt::format("\n  {:<18} {:<26} ", "", "") : " ";
    return fmt::format("  {:<18} {:<26}", f.key, kind) + gap + help + "\n";
}

}  // namespace

std::string key_reference() {
    SceneFile each = scene_of_each();
    std::string text;
    for (const Table& table : tables_of(each, each.files)) {
        if (table.name == "seam.second") continue;
        text += (text.empty() ? "" : "\n") + title(table) + "\n";
        for (const Field& f : table.fields) text += line(f);
    }
    return text;
}

}  // namespace cloth::pipeline
