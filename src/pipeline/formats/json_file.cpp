#include "pipeline/formats/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

nlohmann::json read_json_object(const std::filesystem::path& path) {
    std::string text;
    try {
        text = read_file(path);
    } catch (const Error& error) {
        throw Error(ExitCode::invalid_scene, error.what());
    }
    try {
        nlohmann::json json = nlohmann::json::parse(text);
        if (!json.is_object()) FilePlace{path}.fail("holds no JSON object { … }");
        return json;
    } catch (const nlohmann::json::parse_error& error) {
        const std::size_t end = std::min<std::size_t>(error.byte, text.size());
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
        FilePlace{path, static_cast<std::size_t>(line)}.fail("is no JSON from here on");
    } catch (const nlohmann::json::exception& error) {
        FilePlace{path}.fail(std::string("cannot be read: ") + error.what());
    }
}

}  // namespace cloth::pipeline
