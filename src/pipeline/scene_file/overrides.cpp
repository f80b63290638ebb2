// Sets one key over what a scene file says.

#include <algorithm>
#include <cstdio>
#include <optional>

#include "pipeline/scene_file/reader.h"
#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

/// Keys of which setting one removes the others.
const std::vector<std::vector<std::string>> alternatives{
    {"simulation.time_step", "simulation.substeps"},
    {"cloth.fabric.young_modulus", "cloth.fabric.mu"},
    {"cloth.fabric.young_modulus", "cloth.fabric.lambda"},
    {"cloth.fabric.poisson_ratio", "cloth.fabric.mu"},
    {"cloth.fabric.poisson_ratio", "cloth.fabric.lambda"},
    {"part.fabric.young_modulus", "part.fabric.mu"},
    {"part.fabric.young_modulus", "part.fabric.lambda"},
    {"part.fabric.poisson_ratio", "part.fabric.mu"},
    {"part.fabric.poisson_ratio", "part.fabric.lambda"},
    {"collider.contact_offset", "collider.contact_radius"},
    {"pin.vertices", "pin.box", "pin.nearest", "pin.greatest", "pin.edge", "pin.part"},
    {"seam.first.vertices", "seam.first.box", "seam.first.nearest", "seam.first.greatest", "seam.first.edge",
     "seam.first.part"},
    {"seam.second.vertices", "seam.second.box", "seam.second.nearest", "seam.second.greatest",
     "seam.second.edge", "seam.second.part"},
};

bool is_list(const std::string& table) {
    return std::any_of(root_tables().begin(), root_tables().end(),
                       [&](const RootTable& t) { return t.listed && t.name == table; });
}

void set_value(toml::table& table, const std::string& key, const std::string& text) {
    try {
        toml::table parsed = toml::parse("value = " + text);
        if (parsed.size() == 1 && parsed.contains("value")) {
            parsed.get("value")->visit([&](auto& value) { table.insert_or_assign(key, std::move(value)); });
            return;
        }
    } catch (const toml::parse_error&) {
        // A bare word is a string.
    }
    // Its text goes into `resolved`, which has to be UTF-8.
    const toml::table parsed = toml::parse("value = " + Value<std::string>::write(text));
    table.insert_or_assign(key, *parsed.get("value")->value<std::string>());
}

void remove_alternatives(toml::table& table, const std::string& plain, const std::string& name) {
    const std::string prefix = plain.substr(0, plain.size() - name.size());
    for (const auto& group : alternatives) {
        if (std::find(group.begin(), group.end(), plain) == group.end()) continue;
        for (const std::string& other : group) {
            if (other != plain) table.erase(other.substr(prefix.size()));
        }
    }
    if (plain == "cloth.mesh" || plain == "cloth.radius") {
        for (const char* key : {"size", "resolution", "diagonals"}) table.erase(key);
    }
    if (plain == "cloth.mesh") {
        for (const char* key : {"radius", "rings"}) table.erase(key);
    }
}

}  // namespace

void Reader::override_key(const Override& wanted) {
    const std::string& setting = wanted.setting;
    const std::size_t equals = setting.find('=');
    if (equals == setting.npos || equals == 0) {
        refuse_scene(fmt::format("{}: must be KEY=VALUE", wanted.given));
    }
    const std::string text = setting.substr(equals + 1);
    const std::string key = setting.substr(0, setting.find_last_not_of(' ', equals - 1) + 1);
    auto refuse = [&](const std::string& message) { refuse_override(wanted, key, message); };

    // a.b[2].c → steps "a", "b", 2, "c"; a list without an index means its first entry.
    toml::table* table = &root_;
    std::string path, plain;
    std::size_t begin = 0;
    while (true) {
        const std::size_t end = std::min(key.find('.', begin), key.size());
        std::string name = key.substr(begin, end - begin);
        std::optional<std::size_t> index;
        if (const std::size_t bracket = name.find('['); bracket != name.npos) {
            std::size_t value = 0;
            char rest = 0;
            if (std::sscanf(name.c_str() + bracket, "[%zu%c", &value, &rest) != 2 || rest != ']' ||
                name.back() != ']') {
                refuse("an index is written [0], [1], …");
            }
            index = value;
            name.resize(bracket);
        }
        if (name.empty()) refuse("a part of the key is empty");
        plain += (plain.empty() ? "" : ".") + name;
        const bool last = end == key.size();
        const bool list = is_list(plain);
        if (index && !list) refuse(fmt::format("\"{}\" is no list of tables", plain));
        if (last) {
            if (list || index) refuse("names a whole table; name one of its keys");
            path += (path.empty() ? "" : ".") + name;
            if (text.find_first_not_of(' ') == text.npos) refuse("has no value");
            try {
                set_value(*table, name, text);
            } catch (const toml::parse_error&) {
                refuse("has a value that is not UTF-8 text");
            }
            remove_alternatives(*table, plain, name);
            break;
        }
        if (list) {
            const std::size_t number = index.value_or(0);
            if (plain == "light" && !table->contains(name)) table->insert(name, toml::array{toml::table{}});
            if (plain == "light" && table->get(name)->is_table()) {
                table = table->get_as<toml::table>(name);
            } else {
                toml::array* array = table->get_as<toml::array>(name);
                const std::size_t count = array ? array->size() : 0;
                if (number >= count || !array->get(number)->is_table()) {
                    refuse(fmt::format("the scene has {} [[{}]], counted from 0", count, name));
                }
                table = array->get(number)->as_table();
            }
            path += (path.empty() ? "" : ".") + fmt::format("{}[{}]", name, number);
        } else {
            const bool fabric = plain == "cloth.fabric" || plain == "part.fabric";
            if (fabric && !table->contains(name)) table->insert(name, default_fabric().name);
            if (!table->contains(name)) table->insert(name, toml::table{});
            if (toml::node* word = table->get(name); fabric && word->is_string()) {
                toml::table named;
                named.insert("base", std::move(*word->as_string()));
                table->insert_or_assign(name, std::move(named));
            }
            if (!table->get(name)->is_table()) refuse(fmt::format("\"{}\" is no table", plain));
            table = table->get_as<toml::table>(name);
            path += (path.empty() ? "" : ".") + name;
        }
        begin = end + 1;
    }
    overridden_.insert_or_assign(path, wanted);
}

}  // namespace cloth::pipeline
