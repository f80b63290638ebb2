#include "pipeline/scene_file/reader.h"

#include <algorithm>
#include <cstdlib>

#include "base/text.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

void refuse_scene(const std::string& message) {
    throw Error(ExitCode::invalid_scene, one_line(message));
}

void refuse_override(const Override& wanted, const std::string& key, const std::string& message) {
    throw Error(wanted.refusal, one_line(fmt::format("{}: {}: {}", wanted.given, key, message)));
}

void Reader::parse(const std::string& text) {
    try {
        root_ = toml::parse(text, label_);
    } catch (const toml::parse_error& error) {
        refuse_scene(fmt::format("{}:{}:{}: {}", label_, error.source().begin.line,
                                 error.source().begin.column, error.description()));
    }
}

void Reader::read(const toml::table& table, const std::string& path, const Fields& fields,
                  const std::vector<std::string>& nested) {
    for (const auto& [toml_key, node] : table) {
        const std::string key(toml_key.str());
        const std::string full = path.empty() ? key : path + "." + key;
        if (std::find(nested.begin(), nested.end(), key) != nested.end()) continue;
        const auto found =
            std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
        if (found == fields.end())
            fail_at(toml_key.source(), full, "unknown key; " + suggestion(key, fields, nested));
        try {
            found->read(node);
        } catch (const BadValue& bad) {
            fail_at(bad.place.value_or(node.source()), full + bad.part,
                    bad.what + (bad.unit_said ? "" : unit_suffix(*found)));
        }
    }
}

const toml::table* Reader::table(const std::string& key) {
    const toml::node* node = root_.get(key);
    if (!node) return nullptr;
    if (!node->is_table())
        fail_at(node->source(), key, "is " + type_name(*node) + "; must be a table, [" + key + "]");
    return node->as_table();
}

std::vector<const toml::table*> Reader::list(const std::string& key) {
    std::vector<const toml::table*> tables;
    const toml::node* node = root_.get(key);
    if (!node) return tables;
    if (const toml::array* array = node->as_array()) {
        for (const toml::node& entry : *array) {
            if (!entry.is_table()) {
                fail_at(entry.source(), key, "is " + type_name(entry) + "; must be a table, [[" + key + "]]");
            }
            tables.push_back(entry.as_table());
        }
    } else if (key == "light" && node->is_table()) {
        tables.push_back(node->as_table());
    } else {
        fail_at(node->source(), key,
                "is " + type_name(*node) + "; must be a list of tables, [[" + key + "]]");
    }
    return tables;
}

namespace {

/// The deepest part of a dotted key that a table has, and whether that is all of it.
std::pair<const toml::node*, bool> walk(const toml::table& root, const std::string& key) {
    const toml::node* node = &root;
    std::string rest = key;
    while (!rest.empty()) {
        const std::size_t end = rest.find_first_of(".[", 1);
        const std::string part = rest.substr(0, end);
        const toml::node* next = nullptr;
        if (part[0] == '[') {
            // A list of one may be written as a table.
            if (node->is_table() && part == "[0]") next = node;
            if (node->is_array()) next = node->as_array()->get(std::strtoul(part.c_str() + 1, nullptr, 10));
        } else if (node->is_table()) {
            next = node->as_table()->get(part);
        }
        if (!next) return {node, false};
        node = next;
        rest = end == rest.npos ? "" : rest.substr(end + (rest[end] == '.'));
    }
    return {node, true};
}

}  // namespace

const toml::node* Reader::find(const std::string& key) const {
    const auto [node, whole] = walk(root_, key);
    return whole ? node : nullptr;
}

void Reader::fail(const std::string& key, const std::string& message) {
    fail_at(walk(root_, key).first->source(), key, message);
}

fs::path Reader::find_file(const std::string& name) const {
    const fs::path path(name);
    if (path.is_absolute()) return path;
    std::error_code ignored;
    if (fs::exists(folder_ / path, ignored)) return fs::absolute(folder_ / path).lexically_normal();
    return fs::absolute(path).lexically_normal();
}

void Reader::fail_at(const toml::source_region& place, const std::string& key, const std::string& message) {
    // Longest overridden key that is this one or holds it.
    std::string owner;
    for (const auto& [path, wanted] : overridden_) {
        const bool same = key == path || key.starts_with(path + ".") || key.starts_with(path + "[") ||
                          path.starts_with(key + ".");
        if (same && (owner.empty() || path.size() > owner.size())) owner = path;
    }
    if (!owner.empty()) refuse_override(overridden_.at(owner), key, message);
    refuse_scene(fmt::format("{}:{}:{}: {}: {}", label_, std::max<unsigned>(1, place.begin.line),
                             std::max<unsigned>(1, place.begin.column), key, message));
}

}  // namespace cloth::pipeline
