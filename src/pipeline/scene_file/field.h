#pragma once
// One key of a table of a scene file: how it is read into its place, written back and told of.

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "pipeline/scene_file/picture_desc.h"
#include "pipeline/scene_file/toml_value.h"

namespace cloth::pipeline {

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
inline void check_range(double value, double low, double high, const std::string& unit) {
    if (value >= low && value <= high) return;
    throw BadValue{.what = fmt::format("is {:g}; must be {:g} … {:g}{}{}", value, low, high,
                                       unit.empty() ? "" : " ", unit),
                   .unit_said = true};
}
inline void check_range(const std::vector<int>& values, double low, double high, const std::string& unit) {
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

inline std::string unit_suffix(const Field& field) {
    const bool has_unit = !field.unit.empty() && field.unit.find(',') == field.unit.npos;
    return has_unit ? " [" + field.unit + "]" : "";
}

/// "known here: …", or the nearest of them.
inline std::string suggestion(const std::string& key, const Fields& fields,
                              const std::vector<std::string>& more) {
    std::vector<std::string> known = more;
    for (const Field& f : fields) known.push_back(f.key);
    const std::string near = nearest_word(key, known);
    if (near.empty()) return "known here: " + join(known);
    const auto f = std::find_if(fields.begin(), fields.end(), [&](const Field& g) { return g.key == near; });
    return fmt::format("did you mean \"{}\"{}?", near, f == fields.end() ? "" : unit_suffix(*f));
}

/// An optional value that a file leaves out by 0.
inline Field field_or_none(const char* key, const char* unit, const char* help,
                           std::optional<double>& target) {
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

inline Fields motion_fields(MotionKey& key) {
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

inline std::string write_key(const Fields& fields) {
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

inline Fields camera_key_fields(CameraKey& key) {
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
}  // namespace cloth::pipeline
