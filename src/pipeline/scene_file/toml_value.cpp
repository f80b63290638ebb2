#include "pipeline/scene_file/toml_value.h"

#include <cmath>
#include <cstdlib>

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

void wrong_type(const toml::node& node, const std::string& wanted) {
    throw BadValue{"is " + type_name(node) + "; must be " + wanted};
}

const toml::array& array_of(const toml::node& node, std::size_t size, const std::string& wanted) {
    const toml::array* array = node.as_array();
    if (!array) wrong_type(node, wanted);
    if (size && array->size() != size) {
        throw BadValue{fmt::format("has {} entries; must be {}", array->size(), wanted)};
    }
    return *array;
}

// ---------------------------------------------------------------- written

namespace {

/// TOML tells a float from an integer by its point or exponent.
std::string with_point(std::string text) {
    if (text.find_first_of(".en") == text.npos) text += ".0";
    return text;
}

}  // namespace

std::string digits(double value) {
    return with_point(fmt::format("{}", value));
}

std::string digits(float value) {
    return with_point(fmt::format("{}", value));
}

std::string Value<std::string>::write(const std::string& value) {
    std::string text = "\"";
    for (char c : value) {
        if (c == '"' || c == '\\') text += '\\';
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            text += fmt::format("\\u{:04x}", static_cast<int>(c));
        } else {
            text += c;
        }
    }
    return text + "\"";
}

std::string Value<render::Float3>::write(const render::Float3& v) {
    return "[" + digits(v[0]) + ", " + digits(v[1]) + ", " + digits(v[2]) + "]";
}

// ---------------------------------------------------------------- schemas

std::string number_schema(bool whole, const Range& range) {
    std::string text = whole ? R"({"type":"integer")" : R"({"type":"number")";
    const auto bound = [&](double value, bool open, const char* name, const char* open_name) {
        if (std::isfinite(value))
            text += fmt::format(",\"{}\":{}", open ? open_name : name, number_text(value));
    };
    bound(range.low, range.above, "minimum", "exclusiveMinimum");
    bound(range.high, range.below, "maximum", "exclusiveMaximum");
    text += "}";
    return range.zero_is_none && !range.holds(0.0) ? R"({"anyOf":[{"const":0},)" + text + "]}" : text;
}

std::string list_schema(const std::string& entry, std::size_t least, std::size_t most) {
    std::string text = R"({"type":"array","items":)" + entry;
    if (least > 0) text += fmt::format(",\"minItems\":{}", least);
    if (most > 0) text += fmt::format(",\"maxItems\":{}", most);
    return text + "}";
}

std::string words_schema(const std::vector<std::string>& words) {
    return R"({"enum":[")" + join(words, R"(",")") + R"("]})";
}

// ---------------------------------------------------------------- read

double Value<double>::read(const toml::node& node) {
    const auto value = node.value<double>();
    if (!value || node.is_boolean() || node.is_string()) wrong_type(node, "a number");
    if (!std::isfinite(*value)) throw BadValue{"is not finite; must be a finite number"};
    return *value;
}

namespace {

std::int64_t whole_number(const toml::node& node, const char* wanted, std::int64_t low, std::int64_t high,
                          const char* range) {
    if (!node.is_integer()) wrong_type(node, wanted);
    const std::int64_t value = *node.value<std::int64_t>();
    if (value < low || value > high) throw BadValue{fmt::format("is {}; must be {}", value, range)};
    return value;
}

}  // namespace

int Value<int>::read(const toml::node& node) {
    return static_cast<int>(whole_number(node, "a whole number", -2147483648LL, 2147483647LL,
                                         "between -2147483648 and 2147483647"));
}

std::uint32_t Value<std::uint32_t>::read(const toml::node& node) {
    return static_cast<std::uint32_t>(
        whole_number(node, "a whole number", 0, 4294967295LL, "0 … 4294967295"));
}

bool Value<bool>::read(const toml::node& node) {
    if (!node.is_boolean()) wrong_type(node, "true or false");
    return *node.value<bool>();
}

std::string Value<std::string>::read(const toml::node& node) {
    if (!node.is_string()) wrong_type(node, "a string");
    return *node.value<std::string>();
}

render::Float3 Value<render::Float3>::read(const toml::node& node) {
    const Vec3 v = Value<Vec3>::read(node);
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::array<int, 2> Value<std::array<int, 2>>::read(const toml::node& node) {
    if (node.is_integer()) return {Value<int>::read(node), Value<int>::read(node)};
    if (!node.is_array()) wrong_type(node, "a " + words());
    const toml::array& array = array_of(node, 2, "two entries");
    return {Value<int>::read(array[0]), Value<int>::read(array[1])};
}

DragDesc::Key Value<DragDesc::Key>::read(const toml::node& node) {
    const toml::array& array = array_of(node, 3, words());
    return {Value<double>::read(array[0]), {Value<double>::read(array[1]), Value<double>::read(array[2])}};
}

PixelSize Value<PixelSize>::read(const toml::node& node) {
    if (node.is_array()) {
        const toml::array& array = array_of(node, 2, "\"WIDTHxHEIGHT\" or [width, height]");
        return {Value<int>::read(array[0]), Value<int>::read(array[1])};
    }
    const std::string text = node.is_string() ? *node.value<std::string>() : "";
    const std::size_t x = text.find('x');
    const auto side = [&](const std::string& digits) {
        if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != digits.npos) {
            throw BadValue{.what = fmt::format("is {}; must be \"WIDTHxHEIGHT\" or [width, height]",
                                               node.is_string() ? '"' + text + '"' : type_name(node)),
                           .unit_said = false};
        }
        return std::stoi(digits);
    };
    return {side(text.substr(0, x)), side(x == text.npos ? "" : text.substr(x + 1))};
}

Color Value<Color>::read(const toml::node& node) {
    static const char* wanted = "\"#rrggbb\" or [red, green, blue], each 0 … 1 (sRGB)";
    if (node.is_array()) {
        if (node.as_array()->size() != 3) throw BadValue{fmt::format("must be {}", wanted)};
        const Color color{Value<Vec3>::read(node)};
        if ((color.srgb.array() < 0.0).any() || (color.srgb.array() > 1.0).any()) {
            throw BadValue{fmt::format("is out of range; must be {}", wanted)};
        }
        return color;
    }
    const std::string text = node.is_string() ? *node.value<std::string>() : "";
    if (text.size() != 7 || text[0] != '#' ||
        text.find_first_not_of("0123456789abcdefABCDEF", 1) != text.npos) {
        wrong_type(node, wanted);
    }
    const long rgb = std::strtol(text.c_str() + 1, nullptr, 16);
    return {Vec3(static_cast<double>(rgb >> 16), static_cast<double>((rgb >> 8) & 255),
                 static_cast<double>(rgb & 255)) /
            255.0};
}

PicturePlace Value<PicturePlace>::read(const toml::node& node) {
    const toml::array& array = array_of(node, 0, words());
    if (array.size() != 2 && array.size() != 3)
        throw BadValue{fmt::format("has {} entries; must be {}", array.size(), words())};
    PicturePlace place{Value<double>::read(array[0]), Value<double>::read(array[1])};
    if (array.size() == 3) place.radius = Value<double>::read(array[2]);
    if (place.radius < 0)
        throw BadValue{fmt::format("has the radius {:g}; must be at least 0", place.radius)};
    return place;
}

std::optional<std::string> Caption::read(const toml::node& node) {
    if (node.is_boolean()) return Value<bool>::read(node) ? std::optional(default_caption) : std::nullopt;
    if (!node.is_string()) wrong_type(node, "true, false or a text");
    const std::string text = Value<std::string>::read(node);
    for (std::size_t at = text.find('{'); at != text.npos; at = text.find('{', at + 1)) {
        const std::size_t end = text.find('}', at);
        const std::string name = end == text.npos ? "" : text.substr(at + 1, end - at - 1);
        if (name != "scene" && name != "time" && name != "frame" && name != "description")
            throw BadValue{fmt::format("has \"{}\"; known: {{scene}}, {{time}}, {{frame}}, {{description}}",
                                       text.substr(at, end == text.npos ? end : end - at + 1))};
    }
    return text;
}

std::size_t read_word(const toml::node& node, const std::vector<std::string>& words) {
    const std::string text = Value<std::string>::read(node);
    const auto found = std::find(words.begin(), words.end(), text);
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
    const std::string near = nearest_word(text, words);
    throw BadValue{near.empty()
                       ? fmt::format("is \"{}\"; must be one of {}", text, join(words))
                       : fmt::format("is \"{}\"; did you mean \"{}\"? (one of {})", text, near, join(words))};
}

}  // namespace cloth::pipeline
