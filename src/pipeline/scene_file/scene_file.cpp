#include "pipeline/scene_file/scene_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "base/portable_math.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_file.h"
#include "render/image/image.h"
#include "sim/model.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"

namespace cloth::pipeline {
namespace {

namespace fs = std::filesystem;

// ---------------------------------------------------------------- values

/// A message is one line, whatever text a file or an argument holds.
[[noreturn]] void refuse_scene(std::string message) {
    for (char& c : message) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    throw Error(ExitCode::invalid_scene, message);
}

/// A value that does not fit its key; `what` says what would be right.
struct BadValue {
    std::string what;
    std::string part{};                          ///< of the key, "[1].time", where a part alone is bad
    std::optional<toml::source_region> place{};  ///< of that part
    bool unit_said = false;                      ///< whether `what` has the key's unit already
};

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

/// How each type of field is read from a TOML node and written back.
template <class T>
struct Value;

template <>
struct Value<double> {
    static constexpr const char* wanted = "a number";
    static double read(const toml::node& node) {
        const auto value = node.value<double>();
        if (!value || node.is_boolean() || node.is_string()) wrong_type(node, wanted);
        if (!std::isfinite(*value)) throw BadValue{"is not finite; must be a finite number"};
        return *value;
    }
    static std::string write(double value) { return digits(value); }
};

template <>
struct Value<float> {
    static float read(const toml::node& node) { return static_cast<float>(Value<double>::read(node)); }
    static std::string write(float value) { return digits(static_cast<double>(value)); }
};

template <>
struct Value<int> {
    static int read(const toml::node& node) {
        if (!node.is_integer()) wrong_type(node, "a whole number");
        const std::int64_t value = *node.value<std::int64_t>();
        if (value < -2147483648LL || value > 2147483647LL) {
            throw BadValue{fmt::format("is {}; must be between -2147483648 and 2147483647", value)};
        }
        return static_cast<int>(value);
    }
    static std::string write(int value) { return std::to_string(value); }
};

template <>
struct Value<std::uint32_t> {
    static std::uint32_t read(const toml::node& node) {
        if (!node.is_integer()) wrong_type(node, "a whole number");
        const std::int64_t value = *node.value<std::int64_t>();
        if (value < 0 || value > 4294967295LL)
            throw BadValue{fmt::format("is {}; must be 0 … 4294967295", value)};
        return static_cast<std::uint32_t>(value);
    }
    static std::string write(std::uint32_t value) { return std::to_string(value); }
};

template <>
struct Value<bool> {
    static bool read(const toml::node& node) {
        if (!node.is_boolean()) wrong_type(node, "true or false");
        return *node.value<bool>();
    }
    static std::string write(bool value) { return value ? "true" : "false"; }
};

template <>
struct Value<std::string> {
    static std::string read(const toml::node& node) {
        if (!node.is_string()) wrong_type(node, "a string");
        return *node.value<std::string>();
    }
    static std::string write(const std::string& value) {
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
};

const toml::array& array_of(const toml::node& node, std::size_t size, const std::string& wanted) {
    const toml::array* array = node.as_array();
    if (!array) wrong_type(node, wanted);
    if (size && array->size() != size) {
        throw BadValue{fmt::format("has {} entries; must be {}", array->size(), wanted)};
    }
    return *array;
}

template <int N>
struct Value<Eigen::Matrix<double, N, 1>> {
    static Eigen::Matrix<double, N, 1> read(const toml::node& node) {
        const toml::array& array = array_of(node, N, N == 2 ? "[x, y]" : "[x, y, z]");
        Eigen::Matrix<double, N, 1> value;
        for (int i = 0; i < N; ++i) value(i) = Value<double>::read(array[i]);
        return value;
    }
    static std::string write(const Eigen::Matrix<double, N, 1>& value) {
        std::string text;
        for (int i = 0; i < N; ++i) text += (i ? ", " : "[") + digits(value(i));
        return text + "]";
    }
};

template <class T>
struct Value<std::vector<T>> {
    static std::vector<T> read(const toml::node& node) {
        std::vector<T> values;
        for (const toml::node& entry : array_of(node, 0, "an array")) {
            try {
                values.push_back(Value<T>::read(entry));
            } catch (BadValue& bad) {
                if (bad.place) bad.part = fmt::format("[{}]{}", values.size(), bad.part);
                throw;
            }
        }
        return values;
    }
    static std::string write(const std::vector<T>& values) {
        std::string text;
        for (const T& value : values) text += (text.empty() ? "" : ", ") + Value<T>::write(value);
        return "[" + text + "]";
    }
};

template <class T>
struct Value<std::array<T, 2>> {
    static std::array<T, 2> read(const toml::node& node) {
        const toml::array& array = array_of(node, 2, "two entries");
        return {Value<T>::read(array[0]), Value<T>::read(array[1])};
    }
    static std::string write(const std::array<T, 2>& v) {
        return "[" + Value<T>::write(v[0]) + ", " + Value<T>::write(v[1]) + "]";
    }
};

template <>
struct Value<DragDesc::Key> {
    static DragDesc::Key read(const toml::node& node) {
        const toml::array& array = array_of(node, 3, "[time, x, y]");
        return {Value<double>::read(array[0]),
                {Value<double>::read(array[1]), Value<double>::read(array[2])}};
    }
    static std::string write(const DragDesc::Key& key) {
        return Value<Vec3>::write(Vec3(key.time, key.pixel.x(), key.pixel.y()));
    }
};

/// One whole number for both directions, or [x, y].
struct Resolution {
    static constexpr const char* type = "whole number or [along x, along y]";
    std::array<int, 2> count;
};
template <>
struct Value<Resolution> {
    static Resolution read(const toml::node& node) {
        if (node.is_integer()) return {{Value<int>::read(node), Value<int>::read(node)}};
        if (!node.is_array()) wrong_type(node, "a whole number or [along x, along y]");
        return {Value<std::array<int, 2>>::read(node)};
    }
    static std::string write(const Resolution& r) { return Value<std::array<int, 2>>::write(r.count); }
};

/// A cloth by its name, or by its index counted from 0.
struct ClothReference {
    static constexpr const char* type = "name or index";
    std::string name;
    int index = -1;  ///< used where the name is empty
};
template <>
struct Value<ClothReference> {
    static ClothReference read(const toml::node& node) {
        if (node.is_integer()) return {"", Value<int>::read(node)};
        if (!node.is_string()) wrong_type(node, "a cloth's name or its index");
        return {Value<std::string>::read(node)};
    }
    static std::string write(const ClothReference& r) {
        return r.name.empty() ? std::to_string(r.index) : Value<std::string>::write(r.name);
    }
};

/// "640x360" or [640, 360].
struct PixelSize {
    static constexpr const char* type = "\"WxH\" or [width, height]";
    int width, height;
};
template <>
struct Value<PixelSize> {
    static PixelSize read(const toml::node& node) {
        PixelSize size{0, 0};
        if (node.is_array()) {
            const auto pair = Value<std::array<int, 2>>::read(node);
            size = {pair[0], pair[1]};
        } else {
            const std::string text = node.is_string() ? *node.value<std::string>() : "";
            const std::size_t x = text.find('x');
            const auto side = [&](const std::string& digits) {
                if (digits.empty() || digits.size() > 9 ||
                    digits.find_first_not_of("0123456789") != digits.npos) {
                    throw BadValue{fmt::format("is {}; must be \"WIDTHxHEIGHT\" or [width, height]",
                                               node.is_string() ? '"' + text + '"' : type_name(node))};
                }
                return std::stoi(digits);
            };
            size.width = side(text.substr(0, x));
            size.height = side(x == text.npos ? "" : text.substr(x + 1));
        }
        for (int side : {size.width, size.height}) {
            if (side < 16 || side > 8192)
                throw BadValue{fmt::format("has a side of {} pixel; must be 16 … 8192", side)};
        }
        return size;
    }
    static std::string write(const PixelSize& s) { return fmt::format("[{}, {}]", s.width, s.height); }
};

/// sRGB, as "#rrggbb" or [r, g, b] in 0 … 1; kept as it was given, used in linear light.
struct Color {
    static constexpr const char* type = "\"#rrggbb\" or [r, g, b]";
    Vec3 srgb;
    render::Float3 linear() const {
        render::Float3 result{};
        for (int i = 0; i < 3; ++i) {
            const double c = srgb(i);
            result[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        return result;
    }
};
template <>
struct Value<Color> {
    static Color read(const toml::node& node) {
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
    static std::string write(const Color& color) { return Value<Vec3>::write(color.srgb); }
};

// ---------------------------------------------------------------- suggestions

std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t above = row[j];
            row[j] = std::min({row[j - 1] + 1, above + 1, diagonal + (a[i - 1] != b[j - 1])});
            diagonal = above;
        }
    }
    return row[b.size()];
}

/// The candidate nearest to `word`, or "" where none is near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

std::string join(const std::vector<std::string>& items) {
    std::string text;
    for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
    return text;
}

// ---------------------------------------------------------------- fields

/// One key of a table: how it is read into its place and written back.
struct Field {
    std::string key, unit, help;
    std::function<void(const toml::node&)> read;
    std::function<std::string()> write;  ///< empty text: not set
    std::string type, range;  ///< for the key reference; no range: any, or checked by the simulation
};
using Fields = std::vector<Field>;

template <class T>
struct ListOf {
    using Type = void;
};
template <class T>
struct ListOf<std::vector<T>> {
    using Type = T;
};

/// What a file has to hold, in words.
template <class T>
std::string type_of() {
    using Entry = typename ListOf<T>::Type;
    if constexpr (std::is_same_v<T, double> || std::is_same_v<T, float>)
        return "number";
    else if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::uint32_t>)
        return "whole number";
    else if constexpr (std::is_same_v<T, bool>)
        return "true or false";
    else if constexpr (std::is_same_v<T, std::string>)
        return "text";
    else if constexpr (std::is_same_v<T, Vec2>)
        return "[x, y]";
    else if constexpr (std::is_same_v<T, Vec3>)
        return "[x, y, z]";
    else if constexpr (std::is_same_v<T, std::array<Vec3, 2>>)
        return "[[x, y, z], [x, y, z]]";
    else if constexpr (std::is_same_v<T, std::array<double, 2>>)
        return "[number, number]";
    else if constexpr (std::is_same_v<T, DragDesc::Key>)
        return "[time, x, y]";
    else if constexpr (std::is_same_v<T, PicturePlace>)
        return "[x, y] or [x, y, radius]";
    else if constexpr (std::is_same_v<T, MotionKey>)
        return "{ time, translate, rotate }";
    else if constexpr (std::is_same_v<T, CameraKey>)
        return "{ time, position, target, field_of_view }";
    else if constexpr (!std::is_void_v<Entry>)
        return "list of " + type_of<Entry>();
    else
        return T::type;
}

template <class T>
Field field(const char* key, const char* unit, const char* help, T& target) {
    return {key,
            unit,
            help,
            [&target](const toml::node& node) { target = Value<T>::read(node); },
            [&target] { return Value<T>::write(target); },
            type_of<T>()};
}

template <class T>
Field field(const char* key, const char* unit, const char* help, std::optional<T>& target) {
    return {key,
            unit,
            help,
            [&target](const toml::node& node) { target = Value<T>::read(node); },
            [&target] { return target ? Value<T>::write(*target) : std::string(); },
            type_of<T>()};
}

/// Refuses what lies outside low … high.
void check_range(double value, double low, double high, const std::string& unit) {
    if (value >= low && value <= high) return;
    throw BadValue{.what = fmt::format("is {:g}; must be {:g} … {:g}{}{}", value, low, high,
                                       unit.empty() ? "" : " ", unit),
                   .unit_said = true};
}
void check_range(const std::vector<int>& values, double low, double high, const std::string& unit) {
    for (const int value : values) check_range(value, low, high, unit);
}

/// A number, an optional one, or a list of them, that must be low … high.
template <class T>
Field field(const char* key, const char* unit, const char* help, T& target, double low, double high) {
    Field f = field(key, unit, help, target);
    const auto check = [low, high, unit = std::string(unit)](const auto& value) {
        check_range(value, low, high, unit);
    };
    f.read = [&target, check, read = f.read](const toml::node& node) {
        read(node);
        if constexpr (requires { target.has_value(); }) {
            check(*target);
        } else {
            check(target);
        }
    };
    f.range = fmt::format("{:g} … {:g}", low, high);
    return f;
}

std::string unit_suffix(const Field& field) {
    const bool has_unit = !field.unit.empty() && field.unit.find(',') == field.unit.npos;
    return has_unit ? " [" + field.unit + "]" : "";
}

/// "known here: …", or the nearest of them.
std::string suggestion(const std::string& key, const Fields& fields, const std::vector<std::string>& more) {
    std::vector<std::string> known = more;
    for (const Field& f : fields) known.push_back(f.key);
    const std::string near = nearest_word(key, known);
    if (near.empty()) return "known here: " + join(known);
    const auto f = std::find_if(fields.begin(), fields.end(), [&](const Field& g) { return g.key == near; });
    return fmt::format("did you mean \"{}\"{}?", near, f == fields.end() ? "" : unit_suffix(*f));
}

/// An optional value that a file leaves out by 0.
Field field_or_none(const char* key, const char* unit, const char* help, std::optional<double>& target) {
    return {key,
            unit,
            help,
            [&target](const toml::node& node) {
                const double value = Value<double>::read(node);
                target = value == 0.0 ? std::nullopt : std::optional(value);
            },
            [&target] { return Value<double>::write(target.value_or(0.0)); },
            type_of<double>()};
}

Fields motion_fields(MotionKey& key) {
    return {field("time", "s", "", key.time), field("translate", "m", "", key.translate),
            field("rotate", "degree", "", key.rotate)};
}

/// One key of a path, an inline table that has at least a time.
template <class Key>
Key read_key(const toml::node& node, Fields (*fields_of)(Key&), const char* wanted) {
    const toml::table* table = node.as_table();
    if (!table) throw BadValue{"is " + type_name(node) + "; must be " + wanted, "", node.source()};
    Key key;
    const Fields fields = fields_of(key);
    for (const auto& [toml_key, entry] : *table) {
        const std::string name(toml_key.str());
        const auto found =
            std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == name; });
        if (found == fields.end())
            throw BadValue{"unknown key; " + suggestion(name, fields, {}), "." + name, toml_key.source()};
        try {
            found->read(entry);
        } catch (const BadValue& bad) {
            throw BadValue{bad.what + (bad.unit_said ? "" : unit_suffix(*found)), "." + name, entry.source(),
                           true};
        }
    }
    if (!table->contains("time")) throw BadValue{"has no time [s]", "", node.source()};
    return key;
}

std::string write_key(const Fields& fields) {
    std::string text;
    for (const Field& f : fields)
        if (const std::string value = f.write(); !value.empty())
            text += (text.empty() ? "{ " : ", ") + f.key + " = " + value;
    return text + " }";
}

template <>
struct Value<MotionKey> {
    static MotionKey read(const toml::node& node) {
        return read_key<MotionKey>(node, motion_fields, "{ time, translate, rotate }");
    }
    static std::string write(MotionKey key) { return write_key(motion_fields(key)); }
};

Fields camera_key_fields(CameraKey& key) {
    return {field("time", "s", "", key.time), field("position", "m", "", key.position),
            field("target", "m", "", key.target),
            field("field_of_view", "degree", "", key.field_of_view, 1.0, 160.0)};
}

template <>
struct Value<CameraKey> {
    static CameraKey read(const toml::node& node) {
        return read_key<CameraKey>(node, camera_key_fields, "{ time, position, target, field_of_view }");
    }
    static std::string write(CameraKey key) { return write_key(camera_key_fields(key)); }
};

/// true: the default text; false: none.
struct CaptionText {
    static constexpr const char* type = "true, false or text";
    std::optional<std::string> text;
};
template <>
struct Value<CaptionText> {
    static CaptionText read(const toml::node& node) {
        if (node.is_boolean())
            return {Value<bool>::read(node) ? std::optional(default_caption) : std::nullopt};
        if (!node.is_string()) wrong_type(node, "true, false or a text");
        const std::string text = Value<std::string>::read(node);
        for (std::size_t at = text.find('{'); at != text.npos; at = text.find('{', at + 1)) {
            const std::size_t end = text.find('}', at);
            const std::string name = end == text.npos ? "" : text.substr(at + 1, end - at - 1);
            if (name != "scene" && name != "time" && name != "frame" && name != "description")
                throw BadValue{
                    fmt::format("has \"{}\"; known: {{scene}}, {{time}}, {{frame}}, {{description}}",
                                text.substr(at, end == text.npos ? end : end - at + 1))};
        }
        return {text};
    }
    static std::string write(const CaptionText& caption) {
        return caption.text ? Value<std::string>::write(*caption.text) : "false";
    }
};

template <>
struct Value<PicturePlace> {
    static PicturePlace read(const toml::node& node) {
        const toml::array& array = array_of(node, 0, "[x, y] or [x, y, radius]");
        if (array.size() != 2 && array.size() != 3)
            throw BadValue{fmt::format("has {} entries; must be [x, y] or [x, y, radius]", array.size())};
        PicturePlace place{Value<double>::read(array[0]), Value<double>::read(array[1])};
        if (array.size() == 3) place.radius = Value<double>::read(array[2]);
        if (place.radius < 0)
            throw BadValue{fmt::format("has the radius {:g}; must be at least 0", place.radius)};
        return place;
    }
    static std::string write(const PicturePlace& p) { return Value<Vec3>::write(Vec3(p.x, p.y, p.radius)); }
};

template <class E>
using Names = std::vector<std::pair<const char*, E>>;

template <class E>
Field choice(const char* key, const char* help, E& target, const Names<E>& names) {
    std::vector<std::string> known;
    for (const auto& [name, value] : names) known.push_back(name);
    return {key,
            join(known),
            help,
            [&target, names, known](const toml::node& node) {
                const std::string text = Value<std::string>::read(node);
                for (const auto& [name, value] : names) {
                    if (text == name) {
                        target = value;
                        return;
                    }
                }
                const std::string near = nearest_word(text, known);
                throw BadValue{near.empty() ? fmt::format("is \"{}\"; must be one of {}", text, join(known))
                                            : fmt::format("is \"{}\"; did you mean \"{}\"? (one of {})", text,
                                                          near, join(known))};
            },
            [&target, names] {
                for (const auto& [name, value] : names) {
                    if (value == target) return Value<std::string>::write(name);
                }
                return std::string();
            },
            "one of"};
}

template <class E>
Field choice(const char* key, const char* help, std::optional<E>& target, const Names<E>& names) {
    // Reads through a temporary of the plain kind.
    auto value = std::make_shared<E>();
    Field plain = choice(key, help, *value, names);
    return {plain.key,
            plain.unit,
            plain.help,
            [&target, value, read = plain.read](const toml::node& node) {
                read(node);
                target = *value;
            },
            [&target, value, write = plain.write] {
                if (!target) return std::string();
                *value = *target;
                return write();
            },
            plain.type};
}

/// A list of names, each at most once.
template <class E>
Field choices(const char* key, const char* help, std::vector<E>& target, const Names<E>& names) {
    auto one = std::make_shared<E>();
    const Field single = choice(key, help, *one, names);
    return {key,
            single.unit,
            help,
            [&target, one, read = single.read](const toml::node& node) {
                std::vector<E> values;
                for (const toml::node& entry : array_of(node, 0, "a list of names")) {
                    const std::string part = fmt::format("[{}]", values.size());
                    try {
                        read(entry);
                    } catch (const BadValue& bad) {
                        throw BadValue{bad.what, part, entry.source()};
                    }
                    if (std::find(values.begin(), values.end(), *one) != values.end())
                        throw BadValue{"stands there twice", part, entry.source()};
                    values.push_back(*one);
                }
                target = values;
            },
            [&target, one, write = single.write] {
                std::string text;
                for (const E& value : target) {
                    *one = value;
                    text += (text.empty() ? "" : ", ") + write();
                }
                return "[" + text + "]";
            },
            "list of"};
}

const Names<IntegratorKind> integrator_names{
    {"linearly_implicit_euler", IntegratorKind::linearly_implicit_euler},
    {"implicit_euler", IntegratorKind::implicit_euler},
    {"tr_bdf2", IntegratorKind::tr_bdf2},
    {"implicit_midpoint", IntegratorKind::implicit_midpoint}};
const Names<MembraneKind> membrane_names{{"corotational", MembraneKind::corotational},
                                         {"st_venant_kirchhoff", MembraneKind::st_venant_kirchhoff},
                                         {"neo_hookean", MembraneKind::neo_hookean}};
const Names<BendingKind> bending_names{{"quadratic", BendingKind::quadratic},
                                       {"hinges", BendingKind::hinges}};
const Names<HessianKind> hessian_names{{"assignment", HessianKind::assignment},
                                       {"projected", HessianKind::projected}};
const Names<ContactKind> contact_names{{"velocity_filter", ContactKind::velocity_filter},
                                       {"penalty", ContactKind::penalty},
                                       {"barrier", ContactKind::barrier}};
const Names<Diagonals> diagonal_names{{"uniform", Diagonals::uniform},
                                      {"mirrored", Diagonals::mirrored},
                                      {"alternating", Diagonals::alternating}};
const Names<Shape> shape_names{{"sphere", Shape::sphere},     {"plane", Shape::plane},
                               {"box", Shape::box},           {"capsule", Shape::capsule},
                               {"cylinder", Shape::cylinder}, {"mesh", Shape::mesh}};
const Names<render::Pattern> pattern_names{{"plain", render::Pattern::plain},
                                           {"stripes", render::Pattern::stripes},
                                           {"checks", render::Pattern::checks},
                                           {"tartan", render::Pattern::tartan},
                                           {"dots", render::Pattern::dots}};
const Names<Framing> framing_names{{"fixed", Framing::fixed}, {"auto", Framing::automatic}};
const Names<Curve> curve_choices = [] {
    Names<Curve> names;
    for (const CurveName& n : curve_names) names.emplace_back(n.name, n.curve);
    return names;
}();
const Names<VertexField> shade_names = [] {
    Names<VertexField> names;
    for (const VertexFieldName& n : vertex_field_names()) names.emplace_back(n.name, n.field);
    return names;
}();
const Names<Switch> switch_names{{"on", Switch::on}, {"off", Switch::off}, {"toggle", Switch::toggle}};

// ---------------------------------------------------------------- what a file says

struct LookEntry {
    Color color{Vec3(0.8, 0.8, 0.8)};
    std::optional<Color> back_color;
    double roughness = 0.75, specular = 0.03, sheen = 0.0;

    Fields fields() {
        return {field("color", "sRGB", "colour of the front", color),
                field("back_color", "sRGB", "colour of the back; default: as the front", back_color),
                field("roughness", "", "of the specular lobe", roughness, 0.0, 1.0),
                field("specular", "", "reflectance at normal incidence", specular, 0.0, 1.0),
                field("sheen", "", "soft glow of fibres at grazing angles", sheen, 0.0, 10.0)};
    }
    Look look() const {
        render::Material m;
        m.front = color.linear();
        m.back = back_color.value_or(color).linear();
        m.roughness = static_cast<float>(roughness);
        m.specular = static_cast<float>(specular);
        m.sheen = static_cast<float>(sheen);
        return {m};
    }
};

Fields operator+(Fields a, const Fields& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

struct ClothEntry {
    ClothDesc desc;
    std::optional<Vec2> size;
    std::optional<Resolution> resolution;
    std::optional<Diagonals> diagonals;
    std::optional<double> radius;
    std::optional<int> rings;
    std::optional<std::string> mesh, pose;
    LookEntry look{.color = {Vec3(0.72, 0.16, 0.14)}, .back_color = {}, .sheen = 0.35};
    int subdivisions = 1;
    std::optional<render::Pattern> pattern;
    double pattern_scale = 0.2, weave = 0.0, weave_depth = 0.5, hem = 0.002;
    std::vector<Color> pattern_colors{
        {Vec3(0.93, 0.91, 0.86)}, {Vec3(0.10, 0.14, 0.26)}, {Vec3(0.85, 0.68, 0.25)}};
    std::optional<std::string> texture;
    std::shared_ptr<const render::Image> image;

    Look cloth_look() const {
        Look all = look.look();
        render::Material& m = all.material;
        m.pattern = image ? render::Pattern::image : pattern.value_or(render::Pattern::plain);
        m.pattern_scale = static_cast<float>(pattern_scale);
        for (std::size_t i = 0; i < m.pattern_colors.size(); ++i)
            m.pattern_colors[i] = pattern_colors[std::min(i, pattern_colors.size() - 1)].linear();
        m.pattern_on_back = !look.back_color;
        m.image = image;
        m.weave = static_cast<float>(weave);
        m.weave_depth = static_cast<float>(weave_depth);
        all.subdivisions = subdivisions;
        all.hem = hem;
        return all;
    }
    Fields fields() {
        return Fields{
                   field("name", "", "by which pins refer to it", desc.name),
                   field("size", "m", "of a grid: [along x, along y]", size),
                   field("resolution", "", "of a grid: vertices per side, one number or [along x, along y]",
                         resolution),
                   choice("diagonals", "of a grid: how squares are cut", diagonals, diagonal_names),
                   field("radius", "m", "of a disc, instead of a grid", radius),
                   field("rings", "", "of a disc: rings of vertices around the middle one", rings),
                   field("mesh", "file", "rest shape, instead of a grid or disc", mesh),
                   field("pose", "file", "mesh of the start positions; default: the rest shape", pose),
                   field("scale", "", "of the start pose", desc.transform.scale),
                   field("rotate", "degree", "of the start pose, about fixed x, then y, then z",
                         desc.transform.rotate),
                   field("translate", "m", "of the start pose, after scale and rotate",
                         desc.transform.translate),
                   field("velocity", "m/s", "at the start, of the free vertices", desc.velocity),
                   field("bump", "m", "height of a smooth out-of-plane offset of the start pose", desc.bump),
                   field("warp", "", "direction of the warp on the rest shape", desc.warp),
                   field("contact_thickness", "m", "of contact = \"barrier\": of the sheet as others feel it",
                         desc.contact_thickness),
                   field("subdivisions", "", "Loop steps that smooth the drawn surface", subdivisions, 0, 3),
                   choice("pattern", "on rest coordinates; on the back too, unless that has a colour",
                          pattern, pattern_names),
                   field("pattern_scale", "m", "width of one repeat of pattern or texture", pattern_scale,
                         1e-4, 1000.0),
                   field("pattern_colors", "sRGB", "one to three, beside color", pattern_colors),
                   field("texture", "file", "PNG on rest coordinates, instead of a pattern", texture),
                   field("weave", "m", "spacing of the threads; 0: smooth", weave, 0.0, 1.0),
                   field("weave_depth", "", "slope of the threads' flanks", weave_depth, 0.0, 2.0),
                   field("hem", "m", "thickness of the rim as drawn; 0: none", hem, 0.0, 0.1)} +
               look.fields();
    }
    Fields fabric_fields() {
        Fabric& f = desc.fabric;
        const auto unless_mu = [&f](Field plain) {
            plain.write = [&f, write = plain.write] { return f.mu ? std::string() : write(); };
            return plain;
        };
        return {field("name", "", "what lists call it", f.name),
                field("density", "kg/m²", "mass per area", f.density),
                field("thickness", "m", "multiplies the membrane's moduli", f.thickness),
                choice("membrane", "resistance in the plane", f.membrane, membrane_names),
                unless_mu(field("young_modulus", "Pa", "in-plane; of st_venant_kirchhoff along the warp",
                                f.young_modulus)),
                unless_mu(field("poisson_ratio", "",
                                "in-plane, plane stress; weft's shortening over warp's stretch",
                                f.poisson_ratio)),
                field("young_weft", "Pa", "of st_venant_kirchhoff, along the weft; default: as young_modulus",
                      f.young_weft),
                field("shear_modulus", "Pa",
                      "of st_venant_kirchhoff, of warp against weft; default: as isotropic", f.shear_modulus),
                field("mu", "Pa", "handed to the membrane as it is, with lambda, instead of the moduli above",
                      f.mu),
                field("lambda", "Pa", "see mu", f.lambda),
                field_or_none("strain_limit", "", "stretch that no triangle reaches, above 1; 0: none",
                              f.strain_limit),
                choice("bending_model", "resistance to bending", f.bending_model, bending_names),
                field("bending", "N m", "bending rigidity along the warp", f.bending),
                field("bending_weft", "N m", "along the weft; default: as bending", f.bending_weft),
                field("bending_bias", "N m", "at 45 degrees; default: between warp and weft", f.bending_bias),
                field_or_none("yield_curvature", "1/m", "of hinges: a sharper fold stays in part; 0: elastic",
                              f.yield_curvature),
                field("membrane_damping", "s", "viscous stress over stiffness times strain rate",
                      f.membrane_damping),
                field("bending_damping", "s", "viscous moment over rigidity times curvature rate",
                      f.bending_damping),
                field("friction", "", "Coulomb coefficient", f.friction)};
    }
};

struct ColliderEntry {
    ColliderDesc desc;
    std::optional<std::string> mesh;
    LookEntry look{.color = {Vec3(0.35, 0.42, 0.5)}, .back_color = {}, .roughness = 0.35, .specular = 0.05};

    Fields fields() {
        return Fields{
                   field("name", "", "by which events refer to it", desc.name),
                   choice("shape", "of the collider", desc.shape, shape_names),
                   field("center", "m", "where the shape's origin stands; a point on a plane", desc.center),
                   field("normal", "", "of a plane, outward", desc.normal),
                   field("radius", "m", "of a sphere, capsule or cylinder, as drawn", desc.radius),
                   field("height", "m", "of a capsule's axis or a cylinder, along y", desc.height),
                   field("size", "m", "of a box", desc.size),
                   field("mesh", "file", "of shape = \"mesh\"; open or closed", mesh),
                   field("scale", "", "of a mesh", desc.scale),
                   field("rotate", "degree",
                         "of a box, capsule, cylinder or mesh, about fixed x, then y, then z", desc.rotate),
                   field("path", "",
                         "[{ time, translate, rotate }, …] in s, m, degree: moves it; about center",
                         desc.path),
                   field("spin", "degree/s", "steady turn about center: axis times rate", desc.spin),
                   field("contact_offset", "m", "contact begins this far outside the drawn surface",
                         desc.contact_offset),
                   field("contact_radius", "m", "of a sphere: contact begins here, instead of contact_offset",
                         desc.contact_radius),
                   field("friction", "", "Coulomb coefficient", desc.friction),
                   field("enabled", "", "whether it is on at the start", desc.enabled),
                   field("drawn", "", "whether pictures show it (while it is on)", desc.drawn),
                   field("touchable", "", "whether cloth feels it; false: only drawn", desc.touchable)} +
               look.fields();
    }
};

/// Some of a cloth's vertices, as a pin or a side of a seam names them.
struct SelectionEntry {
    std::optional<ClothReference> cloth;
    std::optional<std::vector<int>> vertices;
    Fields fields(VertexSelection& s) {
        return {field("cloth", "", "name or index of the cloth; default: the first", cloth),
                field("vertices", "", "indices into the cloth's vertices", vertices),
                field("box", "m", "[[x, y, z], [x, y, z]]: lower and upper corner, start pose", s.box),
                field("nearest", "m", "the vertex nearest this point of the start pose", s.nearest),
                field("greatest", "", "x, y, z, -x, -y or -z: the vertices furthest that way", s.greatest),
                field("edge", "", "of a grid: left, right, bottom or top", s.edge),
                field("tolerance", "m", "of greatest", s.tolerance)};
    }
};

struct PinEntry {
    PinDesc desc;
    SelectionEntry selection;
    Fields fields() {
        return selection.fields(desc) +
               Fields{
                   field("path", "", "[{ time, translate, rotate }, …] in s, m, degree: moves the vertices",
                         desc.path),
                   field("center", "m", "of rotate; default: the mean of the vertices", desc.center),
                   field("until", "s", "lets go then; default: never", desc.until)};
    }
};

struct SeamEntry {
    SeamDesc desc;
    std::array<SelectionEntry, 2> selections;
    Fields fields() {
        return {field("reverse", "", "the second side in the opposite order", desc.reverse),
                field("begin", "s", "closing starts", desc.begin),
                field("close_time", "s", "from the start distance to none", desc.close_time),
                field("stiffness", "N/m", "of each spring", desc.stiffness)};
    }
    Fields side_fields(int side) { return selections[side].fields(desc.sides[side]); }
};
const char* const seam_sides[] = {"first", "second"};

struct DragEntry {
    DragDesc desc;
    Fields fields() {
        return {field("path", "s, pixel", "[[time, x, y], …]: pressed at the first, let go at the last",
                      desc.path),
                field("radius", "m", "vertices this near the picked one are picked too", desc.radius),
                field("stiffness", "N/m", "of each spring", desc.stiffness),
                field("viewport", "pixel", "the window that the pixels refer to", desc.viewport)};
    }
};

struct EventEntry {
    EventDesc desc;
    std::optional<std::string> collider, integrator;
    std::optional<Switch> action;
    Fields fields() {
        return {field("time", "s", "acts from the first step that starts then", desc.time),
                field("collider", "name", "the collider that is switched", collider),
                choice("action", "on the collider; default: toggle", action, switch_names),
                field("integrator", "", "toggle, or the name of one", integrator)};
    }
};

struct CameraEntry : CameraDesc {
    Fields fields() {
        return {field("position", "m", "of the eye", position),
                field("target", "m", "what it looks at", target),
                field("up", "", "direction that is up in the picture", up),
                field("field_of_view", "degree", "vertical", field_of_view, 1.0, 160.0),
                field("path", "",
                      "[{ time, position, target, field_of_view }, …]: smooth between these; "
                      "drags still look from where the camera rests",
                      path),
                field("turntable", "degree/s", "turn about the target", turntable, -3600.0, 3600.0),
                choice("frame", "auto: along the same line of sight, all cloth in the picture during the run",
                       framing, framing_names)};
    }
};

struct LightEntry {
    Vec3 direction;
    Color color{Vec3(1.0, 0.985, 0.96)};
    double intensity, softness, angle;
    bool shadow;
    LightEntry() {
        const render::Light light;
        direction = Vec3(light.direction[0], light.direction[1], light.direction[2]);
        intensity = light.intensity;
        softness = std::round(1e6 * light.softness) / 1e6;
        angle = std::round(1e6 * light.angle) / 1e6;
        shadow = light.shadow;
    }
    Fields fields() {
        return {
            field("direction", "", "from the scene towards the light", direction),
            field("color", "sRGB", "of the light", color),
            field("intensity", "", "irradiance of a facing plane", intensity, 0.0, 1e6),
            field("softness", "m", "least half-width of a shadow's edge", softness, 0.0, 1.0),
            field("angle", "degree", "across the light, as seen from the scene; shadows soften with distance",
                  angle, 0.0, 45.0),
            field("shadow", "", "whether it casts shadows", shadow)};
    }
};

struct GroundEntry {
    double height = 0.0;
    Color color{Vec3(0.78, 0.78, 0.78)};
    Fields fields() {
        return {field("height", "m", "y of the floor", height),
                field("color", "sRGB", "of the floor", color)};
    }
};

struct BackgroundEntry {
    Color color{Vec3(0.87, 0.89, 0.91)}, sky{Vec3(0.69, 0.71, 0.75)};
    double exposure = 1.0;
    bool ambient_occlusion = render::View{}.ambient_occlusion;
    Fields fields() {
        return {field("color", "sRGB", "behind everything", color),
                field("sky", "sRGB", "light from above", sky),
                field("ambient_occlusion", "", "folds and corners get less of the sky's light",
                      ambient_occlusion),
                field("exposure", "", "factor on all light", exposure, 1e-6, 1e6)};
    }
};

struct Document {
    int version = 1;
    std::string description;
    Scene scene;
    std::vector<ClothEntry> cloths;
    std::vector<ColliderEntry> colliders;
    std::vector<PinEntry> pins;
    std::vector<SeamEntry> seams;
    std::vector<DragEntry> drags;
    std::vector<EventEntry> events;
    CameraEntry camera;
    LightEntry light;
    std::optional<GroundEntry> ground;
    BackgroundEntry background;
    OutputDesc output;
    AnnotationDesc annotation;
    CaptionText caption;
    PixelSize size{1280, 720};
    ExpectDesc expect;

    Fields top_fields() {
        return {field("version", "", "of the scene format: 1", version),
                field("description", "", "one line for lists", description)};
    }
    Fields simulation_fields() {
        SimulationDesc& s = scene.simulation;
        return {
            field("gravity", "m/s²", "acceleration", s.gravity),
            field("frame_rate", "1/s", "frame k stands at time k / frame_rate", s.frame_rate),
            field("time_step", "s", "longest step; a frame is cut into the fewest equal ones", s.time_step),
            field("substeps", "", "steps per frame, instead of time_step", s.substeps),
            choice("integrator", "how a step is made", s.integrator, integrator_names),
            choice("hessian", "of linearly_implicit_euler", s.hessian, hessian_names),
            choice("contact", "how cloth meets colliders", s.contact, contact_names),
            field("contact_stiffness", "N/m", "of contact = \"penalty\", per vertex", s.contact_stiffness),
            field("sliding_speed", "m/s",
                  "friction is in full force above it; default: 1e-3 with penalty, 1e-5 with barrier",
                  s.sliding_speed),
            field("contact_activation", "m", "of contact = \"barrier\": gap at which repulsion begins",
                  s.contact_activation),
            field("newton_iterations", "", "most of one solve; of all but linearly_implicit_euler",
                  s.newton_iterations),
            field("newton_tolerance", "", "residual at which a solve stops, against the step's start",
                  s.newton_tolerance),
            field(
                "newton_speed", "m/s",
                "of contact = \"barrier\": a solve stops as well where its last step moves no vertex faster, "
                "and the forces left no cloth's mean by a hundredth of it; 0: by newton_tolerance alone",
                s.newton_speed),
            field("retries", "", "times that a step which does not converge is halved", s.retries)};
    }
    Fields air_fields() {
        AirDesc& a = scene.simulation.air;
        return {field("density", "kg/m³", "of the air", a.density),
                field("drag", "", "coefficient of a triangle's projected area; 0: no air", a.drag),
                field("lift", "", "coefficient, at most drag", a.lift),
                field("wind", "m/s", "mean", a.wind),
                field("gusts", "m/s", "root mean square of each component", a.gusts),
                field("gust_length", "m", "longest wave of the gusts", a.gust_length),
                field("seed", "", "of the gusts", a.seed)};
    }
    Fields output_fields() {
        return {
            field("size", "pixel", "of pictures and movie", size),
            field("frames", "", "when the command line does not say", output.frames, 1, 10'000'000),
            field("playback_rate", "1/s", "frames per second of the movie; default: frame_rate",
                  output.playback_rate, 0.01, 1000.0),
            field("quality", "", "H.264 constant rate factor; 0: lossless", output.quality, 0, 51),
            field("caption", "", "true, or a text with {scene}, {time}, {frame}, {description}", caption),
            choice("shade", "shown in colours instead of the fabric", annotation.shade, shade_names),
            field("shade_range", "", "numbers at the ends of the colours; default: of the whole run",
                  annotation.shade_range),
            field("wireframe", "", "the edges of the simulated triangles", annotation.wireframe),
            field("ids", "pixel", "[x, y] or [x, y, radius]: vertex and triangle numbers there, magnified",
                  annotation.ids),
            choices("curves", "drawn in the picture", annotation.curves, curve_choices),
            field("motion_blur", "", "pictures of which each frame is the mean; 1: none",
                  annotation.motion_blur, 1, 64),
            field("shutter", "", "share of a frame's time during which they are taken", annotation.shutter,
                  0.01, 1.0)};
    }
    Fields expect_fields() {
        return {field("state_tolerance", "m", "of golden states made by another build",
                      expect.state_tolerance, 1e-15, 1.0),
                field("frames", "", "golden frames", expect.frames, 0, 10'000'000)};
    }
};

// ---------------------------------------------------------------- reading

/// Keys of which setting one removes the others.
const std::vector<std::vector<std::string>> alternatives{
    {"simulation.time_step", "simulation.substeps"},
    {"cloth.fabric.young_modulus", "cloth.fabric.mu"},
    {"cloth.fabric.young_modulus", "cloth.fabric.lambda"},
    {"cloth.fabric.poisson_ratio", "cloth.fabric.mu"},
    {"cloth.fabric.poisson_ratio", "cloth.fabric.lambda"},
    {"collider.contact_offset", "collider.contact_radius"},
    {"pin.vertices", "pin.box", "pin.nearest", "pin.greatest", "pin.edge"},
    {"seam.first.vertices", "seam.first.box", "seam.first.nearest", "seam.first.greatest", "seam.first.edge"},
    {"seam.second.vertices", "seam.second.box", "seam.second.nearest", "seam.second.greatest",
     "seam.second.edge"},
};
const std::set<std::string> lists{"cloth", "collider", "pin", "seam", "drag", "event", "light"};

class Reader {
  public:
    Reader(std::string label, fs::path folder) : label_(std::move(label)), folder_(std::move(folder)) {}

    void parse(const std::string& text) {
        try {
            root_ = toml::parse(text, label_);
        } catch (const toml::parse_error& error) {
            refuse_scene(fmt::format("{}:{}:{}: {}", label_, error.source().begin.line,
                                     error.source().begin.column, error.description()));
        }
    }

    void override_key(const Override& wanted) {
        const std::string &setting = wanted.setting, &given = wanted.given;
        const std::size_t equals = setting.find('=');
        if (equals == setting.npos || equals == 0) {
            refuse_scene(fmt::format("{}: must be KEY=VALUE", given));
        }
        const std::string text = setting.substr(equals + 1);
        const std::string key = setting.substr(0, setting.find_last_not_of(' ', equals - 1) + 1);
        auto refuse = [&](const std::string& message) {
            refuse_scene(fmt::format("{}: {}: {}", given, key, message));
        };

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
            const bool list = lists.count(plain) == 1;
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
                if (plain == "light" && !table->contains(name))
                    table->insert(name, toml::array{toml::table{}});
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
                if (!table->contains(name)) table->insert(name, toml::table{});
                if (toml::node* word = table->get(name); plain == "cloth.fabric" && word->is_string()) {
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
        overridden_[path] = given;
    }

    /// Reads a table's values by its fields; `nested` lists keys that are tables of their own.
    void read(const toml::table& table, const std::string& path, const Fields& fields,
              const std::vector<std::string>& nested = {}) {
        for (const auto& [toml_key, node] : table) {
            const std::string key(toml_key.str());
            const std::string full = path.empty() ? key : path + "." + key;
            if (std::find(nested.begin(), nested.end(), key) != nested.end()) continue;
            const auto found =
                std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
            if (found == fields.end()) unknown_key(toml_key, full, key, fields, nested);
            try {
                found->read(node);
            } catch (const BadValue& bad) {
                fail_at(bad.place.value_or(node.source()), full + bad.part,
                        bad.what + (bad.unit_said ? "" : unit_suffix(*found)));
            }
        }
    }

    const toml::table* table(const std::string& key) {
        const toml::node* node = root_.get(key);
        if (!node) return nullptr;
        if (!node->is_table())
            fail_at(node->source(), key, "is " + type_name(*node) + "; must be a table, [" + key + "]");
        return node->as_table();
    }

    std::vector<const toml::table*> list(const std::string& key) {
        std::vector<const toml::table*> tables;
        const toml::node* node = root_.get(key);
        if (!node) return tables;
        if (const toml::array* array = node->as_array()) {
            for (const toml::node& entry : *array) {
                if (!entry.is_table()) {
                    fail_at(entry.source(), key,
                            "is " + type_name(entry) + "; must be a table, [[" + key + "]]");
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

    /// Throws for a dotted key, at the place of the deepest part of it that the file has.
    [[noreturn]] void fail(const std::string& key, const std::string& message) {
        const toml::node* node = &root_;
        std::string rest = key;
        while (!rest.empty()) {
            const std::size_t end = rest.find_first_of(".[");
            const std::string name = rest.substr(0, end);
            const toml::node* next = nullptr;
            if (rest[0] == '[') {
                const std::size_t close = rest.find(']');
                if (node->is_array())
                    next = node->as_array()->get(std::strtoul(rest.c_str() + 1, nullptr, 10));
                rest = close == rest.npos ? "" : rest.substr(close + 1);
            } else {
                if (node->is_table()) next = node->as_table()->get(name);
                rest = end == rest.npos ? "" : rest.substr(end);
            }
            if (!rest.empty() && rest[0] == '.') rest.erase(0, 1);
            if (!next) break;
            node = next;
        }
        fail_at(node->source(), key, message);
    }

    /// Relative paths start at the scene file's folder, then at the working folder.
    fs::path find_file(const std::string& name) const {
        const fs::path path(name);
        if (path.is_absolute()) return path;
        std::error_code ignored;
        if (fs::exists(folder_ / path, ignored)) return fs::absolute(folder_ / path).lexically_normal();
        return fs::absolute(path).lexically_normal();
    }

    const toml::table& root() const { return root_; }

  private:
    [[noreturn]] void fail_at(const toml::source_region& place, const std::string& key,
                              const std::string& message) {
        // Longest overridden key that is this one or holds it.
        std::string owner;
        for (const auto& [path, setting] : overridden_) {
            const bool same = key == path || key.starts_with(path + ".") || key.starts_with(path + "[") ||
                              path.starts_with(key + ".");
            if (same && (owner.empty() || path.size() > owner.size())) owner = path;
        }
        if (!owner.empty()) {
            refuse_scene(fmt::format("{}: {}: {}", overridden_[owner], key, message));
        }
        refuse_scene(fmt::format("{}:{}:{}: {}: {}", label_, std::max<unsigned>(1, place.begin.line),
                                 std::max<unsigned>(1, place.begin.column), key, message));
    }

    [[noreturn]] void unknown_key(const toml::key& toml_key, const std::string& full, const std::string& key,
                                  const Fields& fields, const std::vector<std::string>& nested) {
        fail_at(toml_key.source(), full, "unknown key; " + suggestion(key, fields, nested));
    }

    static void set_value(toml::table& table, const std::string& key, const std::string& text) {
        try {
            toml::table parsed = toml::parse("value = " + text);
            if (parsed.size() == 1 && parsed.contains("value")) {
                parsed.get("value")->visit(
                    [&](auto& value) { table.insert_or_assign(key, std::move(value)); });
                return;
            }
        } catch (const toml::parse_error&) {
            // A bare word is a string.
        }
        // Its text goes into `resolved`, which has to be UTF-8.
        const toml::table parsed = toml::parse("value = " + Value<std::string>::write(text));
        table.insert_or_assign(key, *parsed.get("value")->value<std::string>());
    }

    static void remove_alternatives(toml::table& table, const std::string& plain, const std::string& name) {
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

    std::string label_;
    fs::path folder_;
    toml::table root_;
    std::map<std::string, std::string> overridden_;  ///< full key → as the user typed it
};

std::string entry(const char* table, std::size_t index) {
    return fmt::format("{}[{}]", table, index);
}

template <class Entries>
void require_distinct_names(Reader& reader, const char* table, const Entries& entries) {
    std::set<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (!names.insert(entries[i].desc.name).second) {
            reader.fail(entry(table, i) + ".name",
                        fmt::format("\"{}\" is taken; names must differ", entries[i].desc.name));
        }
    }
}

template <class Entries>
int index_of(Reader& reader, const std::string& key, const std::string& name, const Entries& entries,
             const char* what) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (entries[i].desc.name == name) return static_cast<int>(i);
        names.push_back(entries[i].desc.name);
    }
    const std::string near = nearest_word(name, names);
    reader.fail(key, fmt::format("there is no {} \"{}\"; {}", what, name,
                                 !near.empty()   ? fmt::format("did you mean \"{}\"?", near)
                                 : names.empty() ? fmt::format("the scene has none")
                                                 : "known: " + join(names)));
}

Fabric named_fabric(Reader& reader, const toml::node& name, const std::string& key) {
    if (!name.is_string()) reader.fail(key, "is " + type_name(name) + "; must be a fabric's name");
    const std::string text = *name.value<std::string>();
    if (const NamedFabric* found = find_fabric(text)) return found->fabric;
    reader.fail(key, unknown_fabric(text));
}

/// fabric = "cotton", or a table, which may have a base = "cotton".
void read_fabric(Reader& reader, const toml::node& node, const std::string& key, ClothEntry& cloth) {
    Fabric& f = cloth.desc.fabric;
    if (node.is_string()) {
        f = named_fabric(reader, node, key);
        return;
    }
    if (!node.is_table()) {
        reader.fail(key, "is " + type_name(node) + "; must be a fabric's name or a table");
    }
    const toml::table& table = *node.as_table();
    if (table.contains("base")) f = named_fabric(reader, *table.get("base"), key + ".base");
    reader.read(table, key, cloth.fabric_fields(), {"base"});
    // What the table changes leaves parts of its base without a meaning.
    const auto drop = [&](const char* name, auto& value) {
        if (!table.contains(name)) value.reset();
    };
    if (f.mu || f.lambda || f.membrane != MembraneKind::st_venant_kirchhoff) {
        drop("young_weft", f.young_weft);
        drop("shear_modulus", f.shear_modulus);
    }
    if (table.contains("bending") || table.contains("bending_weft")) drop("bending_bias", f.bending_bias);
    if (f.bending_model != BendingKind::hinges) drop("yield_curvature", f.yield_curvature);
    for (const char* name : {"young_modulus", "poisson_ratio"}) {
        if (table.contains(name) && (f.mu || f.lambda)) {
            reader.fail(key + "." + name,
                        "stands beside mu and lambda, which take its place; give one or the other");
        }
    }
}

void read_document(Reader& reader, Document& d) {
    const std::vector<std::string> tables{"simulation", "air",        "cloth",  "collider", "pin",
                                          "seam",       "drag",       "event",  "camera",   "light",
                                          "ground",     "background", "output", "expect"};
    reader.read(reader.root(), "", d.top_fields(), tables);
    if (!reader.root().contains("version")) reader.fail("version", "is missing; write version = 1");
    if (d.version != 1) reader.fail("version", fmt::format("is {}; this program reads version 1", d.version));

    if (const auto* t = reader.table("simulation")) reader.read(*t, "simulation", d.simulation_fields());
    if (const auto* t = reader.table("air")) reader.read(*t, "air", d.air_fields());
    const auto cloths = reader.list("cloth");
    d.cloths.resize(cloths.size());
    for (std::size_t i = 0; i < cloths.size(); ++i) {
        ClothEntry& c = d.cloths[i];
        c.desc.name = cloths.size() == 1 ? "cloth" : fmt::format("cloth{}", i);
        reader.read(*cloths[i], entry("cloth", i), c.fields(), {"fabric"});
        if (const toml::node* fabric = cloths[i]->get("fabric"))
            read_fabric(reader, *fabric, entry("cloth", i) + ".fabric", c);
    }
    const auto colliders = reader.list("collider");
    d.colliders.resize(colliders.size());
    for (std::size_t i = 0; i < colliders.size(); ++i) {
        d.colliders[i].desc.name = colliders.size() == 1 ? "collider" : fmt::format("collider{}", i);
        reader.read(*colliders[i], entry("collider", i), d.colliders[i].fields());
    }
    const auto pins = reader.list("pin");
    d.pins.resize(pins.size());
    for (std::size_t i = 0; i < pins.size(); ++i) reader.read(*pins[i], entry("pin", i), d.pins[i].fields());
    const auto seams = reader.list("seam");
    d.seams.resize(seams.size());
    for (std::size_t i = 0; i < seams.size(); ++i) {
        const std::string key = entry("seam", i);
        reader.read(*seams[i], key, d.seams[i].fields(), {seam_sides[0], seam_sides[1]});
        for (int side = 0; side < 2; ++side) {
            const std::string side_key = key + "." + seam_sides[side];
            const toml::node* node = seams[i]->get(seam_sides[side]);
            if (!node)
                reader.fail(key, fmt::format("has no {}; give the vertices of both sides", seam_sides[side]));
            if (!node->is_table()) {
                reader.fail(side_key,
                            "is " + type_name(*node) + "; must be a table such as { edge = \"left\" }");
            }
            reader.read(*node->as_table(), side_key, d.seams[i].side_fields(side));
        }
    }
    const auto drags = reader.list("drag");
    d.drags.resize(drags.size());
    for (std::size_t i = 0; i < drags.size(); ++i)
        reader.read(*drags[i], entry("drag", i), d.drags[i].fields());
    const auto events = reader.list("event");
    d.events.resize(events.size());
    for (std::size_t i = 0; i < events.size(); ++i)
        reader.read(*events[i], entry("event", i), d.events[i].fields());
    if (const auto* t = reader.table("camera")) reader.read(*t, "camera", d.camera.fields());
    const auto lights = reader.list("light");
    if (lights.size() > 1) reader.fail("light[1]", "there is one light; a second cannot be given");
    if (!lights.empty()) reader.read(*lights[0], "light[0]", d.light.fields());
    if (const auto* t = reader.table("ground")) {
        d.ground.emplace();
        reader.read(*t, "ground", d.ground->fields());
    }
    if (const auto* t = reader.table("background")) reader.read(*t, "background", d.background.fields());
    if (const auto* t = reader.table("output")) reader.read(*t, "output", d.output_fields());
    if (const auto* t = reader.table("expect")) reader.read(*t, "expect", d.expect_fields());
}

// ---------------------------------------------------------------- meaning

template <class Result>
Result load(Reader& reader, const std::string& key, const fs::path& path, Result (*read)(const fs::path&)) {
    try {
        return read(path);
    } catch (const Error& error) {
        reader.fail(key, error.what());
    }
}

void resolve_cloths(Reader& reader, Document& d) {
    require_distinct_names(reader, "cloth", d.cloths);
    for (std::size_t i = 0; i < d.cloths.size(); ++i) {
        ClothEntry& c = d.cloths[i];
        const std::string key = entry("cloth", i);
        if (c.mesh || c.radius) {
            for (const auto& [given, name] :
                 {std::pair{c.size.has_value(), "size"}, std::pair{c.resolution.has_value(), "resolution"},
                  std::pair{c.diagonals.has_value(), "diagonals"}}) {
                if (given) {
                    reader.fail(key + "." + name,
                                fmt::format("belongs to a grid, but the cloth has a {}; give "
                                            "one of the two",
                                            c.mesh ? "mesh" : "radius"));
                }
            }
        }
        if (c.rings && !c.radius) reader.fail(key + ".rings", "belongs to a disc; give its radius too");
        if (c.mesh) {
            if (c.radius) {
                reader.fail(key + ".radius",
                            "belongs to a disc, but the cloth has a mesh; give one of the two");
            }
            const fs::path path = reader.find_file(*c.mesh);
            c.mesh = path.string();
            c.desc.mesh = load(reader, key + ".mesh", path, read_mesh);
        } else if (c.radius) {
            c.desc.disc = Disc{.radius = *c.radius};
            if (c.rings) c.desc.disc->rings = *c.rings;
            c.rings = c.desc.disc->rings;
        } else {
            if (c.size) c.desc.grid.size = *c.size;
            if (c.resolution) c.desc.grid.resolution = c.resolution->count;
            if (c.diagonals) c.desc.grid.diagonals = *c.diagonals;
            c.size = c.desc.grid.size;
            c.resolution = Resolution{c.desc.grid.resolution};
            c.diagonals = c.desc.grid.diagonals;
        }
        if (c.pose) {
            const fs::path path = reader.find_file(*c.pose);
            c.pose = path.string();
            c.desc.pose = load(reader, key + ".pose", path, read_points);
        }
        if (c.texture) {
            if (c.pattern)
                reader.fail(key + ".pattern",
                            "stands beside texture, which takes its place; give one or the other");
            const fs::path path = reader.find_file(*c.texture);
            c.texture = path.string();
            try {
                c.image = std::make_shared<const render::Image>(render::read_png(path));
            } catch (const std::runtime_error& error) {
                reader.fail(key + ".texture", error.what());
            }
        }
        if (c.pattern_colors.empty() || c.pattern_colors.size() > 3)
            reader.fail(key + ".pattern_colors",
                        fmt::format("has {} entries; must be one to three colours", c.pattern_colors.size()));
        d.scene.cloths.push_back(c.desc);
    }
}

void resolve_selection(Reader& reader, const std::string& key, const SelectionEntry& selection,
                       const std::vector<ClothEntry>& cloths, VertexSelection& desc, int& cloth) {
    if (selection.cloth && !selection.cloth->name.empty()) {
        cloth = index_of(reader, key + ".cloth", selection.cloth->name, cloths, "cloth");
    } else if (selection.cloth) {
        cloth = selection.cloth->index;
        if (cloth < 0 || static_cast<std::size_t>(cloth) >= cloths.size()) {
            reader.fail(key + ".cloth", fmt::format("is {}; the scene has {} [[cloth]], counted from 0",
                                                    cloth, cloths.size()));
        }
    }
    if (selection.vertices) {
        if (selection.vertices->empty()) reader.fail(key + ".vertices", "is empty; name at least one vertex");
        desc.vertices = *selection.vertices;
    }
}

void resolve_references(Reader& reader, Document& d) {
    require_distinct_names(reader, "collider", d.colliders);
    for (std::size_t i = 0; i < d.colliders.size(); ++i) {
        ColliderEntry& c = d.colliders[i];
        if (c.mesh) {
            const std::string key = entry("collider", i) + ".mesh";
            if (c.desc.shape != Shape::mesh) reader.fail(key, "belongs to shape = \"mesh\"");
            const fs::path path = reader.find_file(*c.mesh);
            c.mesh = path.string();
            c.desc.mesh = load(reader, key, path, read_mesh);
        }
        d.scene.colliders.push_back(c.desc);
    }
    for (std::size_t i = 0; i < d.pins.size(); ++i) {
        PinEntry& p = d.pins[i];
        resolve_selection(reader, entry("pin", i), p.selection, d.cloths, p.desc, p.desc.cloth);
        d.scene.pins.push_back(p.desc);
    }
    for (std::size_t i = 0; i < d.seams.size(); ++i) {
        SeamEntry& s = d.seams[i];
        for (int side = 0; side < 2; ++side) {
            resolve_selection(reader, entry("seam", i) + "." + seam_sides[side], s.selections[side], d.cloths,
                              s.desc.sides[side], s.desc.sides[side].cloth);
        }
        d.scene.seams.push_back(s.desc);
    }
    for (std::size_t i = 0; i < d.events.size(); ++i) {
        EventEntry& e = d.events[i];
        const std::string key = entry("event", i);
        if (e.collider)
            e.desc.collider = index_of(reader, key + ".collider", *e.collider, d.colliders, "collider");
        if (e.action && !e.collider)
            reader.fail(key + ".action", "acts on a collider; name one with collider");
        e.desc.action = e.action.value_or(Switch::toggle);
        if (e.integrator == "toggle") {
            e.desc.toggle_integrator = true;
        } else if (e.integrator) {
            std::vector<std::string> known{"toggle"};
            for (const auto& [name, value] : integrator_names) {
                known.push_back(name);
                if (*e.integrator == name) e.desc.integrator = value;
            }
            if (!e.desc.integrator) {
                reader.fail(key + ".integrator",
                            fmt::format("is \"{}\"; must be one of {}", *e.integrator, join(known)));
            }
        }
        d.scene.events.push_back(e.desc);
    }
}

void check_camera(Reader& reader, const CameraEntry& camera) {
    if (!camera.path.empty() && camera.framing == Framing::automatic)
        reader.fail("camera.frame",
                    "is \"auto\" beside a path, which says where the camera is; give one of the two");
    for (std::size_t i = 0; i < camera.path.size(); ++i) {
        const CameraKey& key = camera.path[i];
        const std::string place = fmt::format("camera.path[{}]", i);
        if (i > 0 && !(key.time > camera.path[i - 1].time))
            reader.fail(place + ".time", fmt::format("is {:g}; must be later than the key before, {:g} s",
                                                     key.time, camera.path[i - 1].time));
        const Vec3 gaze = key.target.value_or(camera.target) - key.position.value_or(camera.position);
        if (!(gaze.norm() > 1e-9))
            reader.fail(place, "has its target where it stands; it must lie elsewhere");
        if (!(gaze.cross(camera.up).norm() > 1e-3 * gaze.norm() * camera.up.norm()))
            reader.fail(place, "looks along camera.up; it must look across it");
    }
}

void check_annotation(Reader& reader, const AnnotationDesc& a) {
    if (a.shade_range && !a.shade)
        reader.fail("output.shade_range", "belongs to output.shade; name what is shown in colours");
    if (a.shade_range && !((*a.shade_range)[1] > (*a.shade_range)[0]))
        reader.fail("output.shade_range", fmt::format("is [{:g}, {:g}]; the second must be the greater",
                                                      (*a.shade_range)[0], (*a.shade_range)[1]));
}

void check_looks(Reader& reader, Document& d) {
    const Vec3 gaze = d.camera.target - d.camera.position;
    if (!(gaze.norm() > 1e-9))
        reader.fail("camera.target", "is where the camera stands; it must lie elsewhere");
    if (!(gaze.cross(d.camera.up).norm() > 1e-3 * gaze.norm() * d.camera.up.norm())) {
        reader.fail("camera.up", "points along the view; it must lie across it");
    }
    check_camera(reader, d.camera);
    if (!(d.light.direction.norm() > 1e-9))
        reader.fail("light[0].direction", "is zero; must point towards the light");
    check_annotation(reader, d.annotation);
}

/// OpenGL's view and projection matrices of the scene's camera, without the C library's tangent.
void resolve_drags(Document& d) {
    const CameraEntry& camera = d.camera;
    const Vec3 forward = (camera.target - camera.position).normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    const Vec3 up = right.cross(forward);
    Mat4 view = Mat4::Identity();
    view.block<1, 3>(0, 0) = right.transpose();
    view.block<1, 3>(1, 0) = up.transpose();
    view.block<1, 3>(2, 0) = -forward.transpose();
    view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.position;
    constexpr double near_plane = 0.01, far_plane = 100.0;
    for (DragEntry& drag : d.drags) {
        const double scale = 1.0 / tan_degrees(0.5 * camera.field_of_view);
        Mat4& p = drag.desc.projection;
        p.setZero();
        p(0, 0) = scale * drag.desc.viewport.y() / drag.desc.viewport.x();
        p(1, 1) = scale;
        p(2, 2) = -(far_plane + near_plane) / (far_plane - near_plane);
        p(2, 3) = -2.0 * far_plane * near_plane / (far_plane - near_plane);
        p(3, 2) = -1.0;
        drag.desc.view = view;
        d.scene.drags.push_back(drag.desc);
    }
}

// ---------------------------------------------------------------- writing

std::string write_fields(const Fields& fields) {
    std::string text;
    for (const Field& f : fields) {
        const std::string value = f.write();
        if (!value.empty()) text += f.key + " = " + value + "\n";
    }
    return text;
}

std::string write_document(Document& d) {
    std::string text = write_fields(d.top_fields());
    text += "\n[simulation]\n" + write_fields(d.simulation_fields());
    text += "\n[air]\n" + write_fields(d.air_fields());
    for (ClothEntry& c : d.cloths) {
        text += "\n[[cloth]]\n" + write_fields(c.fields()) + "\n[cloth.fabric]\n" +
                write_fields(c.fabric_fields());
    }
    for (ColliderEntry& c : d.colliders) text += "\n[[collider]]\n" + write_fields(c.fields());
    for (PinEntry& p : d.pins) text += "\n[[pin]]\n" + write_fields(p.fields());
    for (SeamEntry& s : d.seams) {
        text += "\n[[seam]]\n" + write_fields(s.fields());
        for (int side = 0; side < 2; ++side)
            text += fmt::format("\n[seam.{}]\n", seam_sides[side]) + write_fields(s.side_fields(side));
    }
    for (DragEntry& drag : d.drags) text += "\n[[drag]]\n" + write_fields(drag.fields());
    for (EventEntry& e : d.events) text += "\n[[event]]\n" + write_fields(e.fields());
    text += "\n[camera]\n" + write_fields(d.camera.fields());
    text += "\n[[light]]\n" + write_fields(d.light.fields());
    if (d.ground) text += "\n[ground]\n" + write_fields(d.ground->fields());
    text += "\n[background]\n" + write_fields(d.background.fields());
    text += "\n[output]\n" + write_fields(d.output_fields());
    text += "\n[expect]\n" + write_fields(d.expect_fields());
    return text;
}

render::Float3 to_float(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::vector<fs::path> scene_files() {
    std::vector<fs::path> files;
    for (const fs::path& folder : scene_folders()) {
        std::error_code ignored;
        for (const auto& file : fs::directory_iterator(folder, ignored)) {
            if (file.path().extension() == ".toml") files.push_back(file.path());
        }
    }
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return a.stem() < b.stem(); });
    return files;
}

std::string read_text(const fs::path& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) refuse_scene(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
    std::string text;
    char buffer[65536];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) text.append(buffer, n);
    std::fclose(file);
    return text;
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& label, const fs::path& folder,
                      const Overrides& overrides) {
    Reader reader(label, folder);
    reader.parse(text);
    for (const Override& each : overrides) reader.override_key(each);

    Document d;
    d.light = LightEntry();
    read_document(reader, d);
    d.output.width = d.size.width;
    d.output.height = d.size.height;
    resolve_cloths(reader, d);
    resolve_references(reader, d);
    check_looks(reader, d);
    resolve_drags(d);
    try {
        validate(d.scene);
        for (std::size_t i = 0; i < d.scene.cloths.size(); ++i) {
            if (d.scene.cloths[i].mesh)
                check_cloth_mesh(*d.scene.cloths[i].mesh, entry("cloth", i) + ".mesh");
        }
        const auto selected = [&](const VertexSelection& selection, int cloth, const std::string& key) {
            const ClothDesc& c = d.scene.cloths[cloth];
            return select_vertices(selection, start_positions(c, rest_shape(c)), key, c.rest_grid()).size();
        };
        for (std::size_t i = 0; i < d.scene.pins.size(); ++i)
            selected(d.scene.pins[i], d.scene.pins[i].cloth, entry("pin", i));
        for (std::size_t i = 0; i < d.scene.seams.size(); ++i) {
            const auto& [first, second] = d.scene.seams[i].sides;
            const std::string key = entry("seam", i);
            const std::size_t a = selected(first, first.cloth, key + ".first"),
                              b = selected(second, second.cloth, key + ".second");
            if (a != b)
                throw SceneError(key + ".second", fmt::format("has {} vertices, the first side {}; a seam "
                                                              "sews one to one, so give as many",
                                                              b, a));
        }
    } catch (const SceneError& error) {
        reader.fail(error.key, error.what());
    }

    SceneFile file;
    file.name = fs::path(label).stem().string();
    file.description = d.description;
    d.scene.name = file.name;
    file.scene = d.scene;
    file.output = d.output;
    file.expect = d.expect;
    for (int frame : file.expect.frames) {
        file.expect.frames_simulated = std::max(file.expect.frames_simulated, frame + 1);
    }
    file.view.width = d.size.width;
    file.view.height = d.size.height;
    file.view.eye = to_float(d.camera.position);
    file.view.target = to_float(d.camera.target);
    file.view.up = to_float(d.camera.up);
    file.view.field_of_view = static_cast<float>(d.camera.field_of_view);
    file.camera = d.camera;
    file.annotation = d.annotation;
    file.annotation.caption = d.caption.text;
    file.view.light.direction = to_float(d.light.direction);
    file.view.light.color = d.light.color.linear();
    file.view.light.intensity = static_cast<float>(d.light.intensity);
    file.view.light.softness = static_cast<float>(d.light.softness);
    file.view.light.angle = static_cast<float>(d.light.angle);
    file.view.light.shadow = d.light.shadow;
    file.view.background = d.background.color.linear();
    file.view.sky = d.background.sky.linear();
    file.view.exposure = static_cast<float>(d.background.exposure);
    file.view.ambient_occlusion = d.background.ambient_occlusion;
    if (d.ground)
        file.ground = render::Ground{static_cast<float>(d.ground->height), d.ground->color.linear()};
    for (const ClothEntry& c : d.cloths) file.cloth_looks.push_back(c.cloth_look());
    for (const ColliderEntry& c : d.colliders) file.collider_looks.push_back(c.look.look());
    file.resolved = write_document(d);
    return file;
}

SceneFile load_scene(const std::string& name_or_path, const Overrides& overrides) {
    std::error_code ignored;
    fs::path path(name_or_path);
    const bool looks_like_path = path.extension() == ".toml" || path.has_parent_path();
    if (!looks_like_path) {
        std::vector<std::string> known;
        path.clear();
        for (const fs::path& file : scene_files()) {
            known.push_back(file.stem().string());
            if (path.empty() && known.back() == name_or_path) path = file;
        }
        if (path.empty()) {
            const std::string near = nearest_word(name_or_path, known);
            refuse_scene(fmt::format("unknown scene \"{}\"; {}(known: {})", name_or_path,
                                     near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near),
                                     join(known)));
        }
    }
    if (!fs::exists(path, ignored)) {
        refuse_scene(fmt::format("{}: there is no such scene file", path.string()));
    }
    if (fs::is_directory(path, ignored)) {
        refuse_scene(fmt::format("{}: is a folder; a scene is a .toml file", path.string()));
    }
    return parse_scene(read_text(path), path.string(), fs::absolute(path).parent_path(), overrides);
}

std::string unknown_fabric(const std::string& name) {
    std::vector<std::string> known;
    for (const NamedFabric& f : named_fabrics()) known.push_back(f.fabric.name);
    const std::string near = nearest_word(name, known);
    return fmt::format("there is no fabric \"{}\"; {}known: {}", name,
                       near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near), join(known));
}

std::vector<fs::path> scene_folders() {
    std::vector<fs::path> folders;
    if (const char* assets = std::getenv("CLOTH_ASSETS")) folders.push_back(fs::path(assets) / "scenes");
    folders.push_back(fs::path(CLOTH_ASSETS_DIR) / "scenes");
    return folders;
}

std::vector<std::array<std::string, 2>> list_scenes() {
    std::vector<std::array<std::string, 2>> result;
    for (const fs::path& file : scene_files()) {
        const std::string name = file.stem().string();
        if (!result.empty() && result.back()[0] == name) continue;
        std::string description;
        try {
            description = toml::parse_file(file.string())["description"].value_or(std::string());
        } catch (const toml::parse_error&) {
            description = "(cannot be read)";
        }
        result.push_back({name, description});
    }
    return result;
}

std::string key_reference() {
    Document d;
    ClothEntry cloth;
    cloth.size = cloth.desc.grid.size;
    cloth.resolution = Resolution{cloth.desc.grid.resolution};
    cloth.diagonals = cloth.desc.grid.diagonals;
    ColliderEntry collider;
    PinEntry pin;
    SeamEntry seam;
    DragEntry drag;
    EventEntry event;
    GroundEntry ground;
    std::string text;
    auto table = [&](const std::string& title, const Fields& fields) {
        text += (text.empty() ? "" : "\n") + title + "\n";
        for (const Field& f : fields) {
            std::string kind = f.type;
            // The unit of a choice is the list of its names.
            const bool names = f.type == "one of" || f.type == "list of";
            if (!f.range.empty()) kind += ", " + f.range;
            if (!f.unit.empty()) kind += names ? " " + f.unit : " [" + f.unit + "]";
            const std::string value = f.write();
            std::string help = f.help;
            if (!value.empty() && value != "\"\"") {
                help += (help.empty() ? "default " : "; default ") + value;
            } else if (help.find("default") == help.npos) {
                help += help.empty() ? "none by default" : "; none by default";
            }
            // A long kind gets a line of its own.
            const bool wide = kind.size() > 26;
            text += fmt::format("  {:<18} {:<26}", f.key, kind);
            text += (wide ? fmt::format("\n  {:<18} {:<26} ", "", "") : " ") + help + "\n";
        }
    };
    table("(top of the file)", d.top_fields());
    table("[simulation]", d.simulation_fields());
    table("[air]", d.air_fields());
    table("[[cloth]]", cloth.fields());
    table("[cloth.fabric]  (or fabric = \"cotton\"; base = \"cotton\" begins with its values)",
          cloth.fabric_fields());
    table("[[collider]]", collider.fields());
    table("[[pin]]", pin.fields());
    table("[[seam]]", seam.fields());
    table("[seam.first], [seam.second]", seam.side_fields(0));
    table("[[drag]]", drag.fields());
    table("[[event]]", event.fields());
    table("[camera]", d.camera.fields());
    table("[[light]]", d.light.fields());
    table("[ground]  (no table: the first level plane that stands still is drawn so, or no floor)",
          ground.fields());
    table("[background]", d.background.fields());
    table("[output]", d.output_fields());
    table("[expect]", d.expect_fields());
    return text;
}

}  // namespace cloth::pipeline
