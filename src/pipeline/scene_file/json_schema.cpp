// A JSON Schema of scene files.

#include <nlohmann/json.hpp>

#include "pipeline/scene_file/tables.h"
#include "sim/scene/fabrics.h"

namespace cloth::pipeline {
namespace {

using Json = nlohmann::ordered_json;

Json field_schema(const Field& f) {
    Json schema = Json::parse(f.schema);
    if (const std::string text =
            f.meaning + (f.meaning.empty() ? "" : " ") + (f.unit.empty() ? "" : "[" + f.unit + "]");
        !text.empty())
        schema["description"] = text;
    if (!f.unit.empty()) schema["unit"] = f.unit;
    // Values are written alike in TOML and JSON, but for inline tables, which no default has.
    if (const std::string value = f.applies ? f.write() : ""; !value.empty())
        schema["default"] = Json::parse(value);
    return schema;
}

Json table_schema(const Table& table) {
    Json schema{{"type", "object"}, {"properties", Json::object()}, {"additionalProperties", false}};
    for (const Field& f : table.fields) schema["properties"][f.key] = field_schema(f);
    return schema;
}

/// A fabric's name, or its numbers, which may begin with those of a named one.
Json fabric_schema(Json numbers) {
    Json names = Json::array();
    for (const NamedFabric& f : named_fabrics()) names.push_back(f.fabric.name);
    numbers["properties"]["base"] = {{"enum", names},
                                     {"description", "the fabric whose values it begins with"}};
    return {{"anyOf", {{{"enum", names}}, std::move(numbers)}}};
}

}  // namespace

std::string json_schema() {
    SceneFile each = scene_of_each();
    const Tables tables = tables_of(each, each.files);
    Json root = table_schema(tables.front());
    Json& properties = root["properties"];
    properties["version"]["const"] = 1;
    for (const Table& table : tables) {
        if (table.name.empty()) continue;
        Json schema = table_schema(table);
        if (table.name == "cloth.fabric") schema = fabric_schema(std::move(schema));
        const std::size_t dot = table.name.find('.');
        if (dot != table.name.npos) {  // its owner is a list
            properties[table.name.substr(0, dot)]["items"]["properties"][table.key()] = std::move(schema);
        } else if (table.listed) {
            properties[table.name] = {{"type", "array"}, {"items", std::move(schema)}};
        } else {
            properties[table.name] = std::move(schema);
        }
    }
    properties["seam"]["items"]["required"] = {"first", "second"};
    properties["light"] = {{"anyOf", {properties["light"]["items"], properties["light"]}}};
    properties["light"]["anyOf"][1]["maxItems"] = 1;
    properties["cloth"]["minItems"] = 1;
    root["required"] = {"version", "cloth"};
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                {"title", "A scene of render_cloth"}};
    schema.update(root);
    return schema.dump(2) + "\n";
}

}  // namespace cloth::pipeline
