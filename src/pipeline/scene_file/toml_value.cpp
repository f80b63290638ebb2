#include "pipeline/scene_file/toml_value.h"

namespace cloth::pipeline {

std::string type_name(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::string:
            return "a string";
        case toml::node_type::integer:
            return "a whole number";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "a boolean";
        default:
            return "a date or time";
    }
}

[[noreturn]] void wrong_type(const toml::node& node, const std::string& wanted) {
    throw BadValue{"is " + type_name(node) + "; must be " + wanted};
}

std::string digits(double value) {
    std::string text = fmt::format("{}", value);  // the shortest that reads back to the same bits
    // TOML tells a float from an integer by its point or exponent.
    if (text.find_first_of(".en") == text.npos) text += ".0";
    return text;
}
}  // namespace cloth::pipeline
