#pragma once
// Checks TOML against the part of JSON Schema that scene files use.

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>

#include <toml++/toml.h>

namespace cloth::testing {

using SchemaJson = nlohmann::ordered_json;

inline bool has_type(const SchemaJson& value, const std::string& type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "integer") return value.is_number_integer();
    return type == "number" && value.is_number();
}

/// JSON pointer to the first value that the schema does not allow; "" where it allows all.
inline std::string fault(const SchemaJson& schema, const SchemaJson& value, const std::string& place) {
    if (schema.contains("anyOf")) {
        for (const SchemaJson& each : schema["anyOf"])
            if (fault(each, value, place).empty()) return "";
        return place;
    }
    bool good = !schema.contains("const") || value == schema["const"];
    if (schema.contains("enum")) {
        bool found = false;
        for (const SchemaJson& each : schema["enum"]) found = found || value == each;
        good = good && found;
    }
    if (schema.contains("type")) {
        const SchemaJson types =
            schema["type"].is_array() ? schema["type"] : SchemaJson::array({schema["type"]});
        bool found = false;
        for (const SchemaJson& each : types) found = found || has_type(value, each);
        good = good && found;
    }
    if (good && value.is_number()) {
        const double v = value;
        good = v >= schema.value("minimum", v) && v <= schema.value("maximum", v) &&
               (!schema.contains("exclusiveMinimum") || v > schema["exclusiveMinimum"].get<double>()) &&
               (!schema.contains("exclusiveMaximum") || v < schema["exclusiveMaximum"].get<double>());
    }
    if (good && value.is_string() && schema.contains("pattern"))
        good = std::regex_search(value.get<std::string>(), std::regex(schema["pattern"].get<std::string>()));
    if (good && value.is_array())
        good = value.size() >= schema.value("minItems", std::size_t{0}) &&
               value.size() <= schema.value("maxItems", value.size());
    if (!good) return place;
    if (value.is_array() && schema.contains("items")) {
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string inner = fault(schema["items"], value[i], place + "/" + std::to_string(i));
            if (!inner.empty()) return inner;
        }
    }
    if (!value.is_object()) return "";
    for (const SchemaJson& key : schema.value("required", SchemaJson::array()))
        if (!value.contains(key)) return place + "/" + key.get<std::string>();
    for (const auto& [key, entry] : value.items()) {
        const bool known = schema["properties"].contains(key);
        const std::string inner =
            known ? fault(schema["properties"][key], entry, place + "/" + key) : place + "/" + key;
        if (!inner.empty()) return inner;
    }
    return "";
}

inline std::string fault(const SchemaJson& schema, const std::string& toml_text) {
    std::ostringstream json;
    json << toml::json_formatter(toml::parse(toml_text));
    return fault(schema, SchemaJson::parse(json.str()), "");
}

}  // namespace cloth::testing
