#pragma once
// How each type of value stands in a scene file: Value<T> reads it from a TOML node, writes it back to the
// bit, says in words what a file has to hold, and as a JSON Schema with the range of its numbers.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "base/text.h"
#include "pipeline/scene_file/picture_desc.h"
#include "sim/scene/schema.h"

namespace cloth::pipeline {

/// A value that does not fit its key; `what` says what would be right.
struct BadValue {
    std::string what;
    std::string part{};                          ///< of the key, "[1].time", where a part alone is bad
    std::optional<toml::source_region> place{};  ///< of that part
    bool unit_said = false;                      ///< whether `what` has the key's unit already
};

/// "a table", "a whole number" …
std::string type_name(const toml::node& node);

[[noreturn]] void wrong_type(const toml::node& node, const std::string& wanted);

/// The entries of an array; of exactly `size` unless that is 0. `wanted` for the refusal.
const toml::array& array_of(const toml::node& node, std::size_t size, const std::string& wanted);

/// The shortest digits that read back to the same bits, with a point or an exponent.
std::string digits(double value);
std::string digits(float value);

/// A JSON Schema of a number, of an array of least … most entries (most 0: any), of one of some words.
std::string number_schema(bool whole, const Range& range);
std::string list_schema(const std::string& entry, std::size_t least, std::size_t most);
std::string words_schema(const std::vector<std::string>& words);

template <class T>
struct Value;

template <>
struct Value<double> {
    static double read(const toml::node& node);
    static std::string write(double value) { return digits(value); }
    static std::string words() { return "number"; }
    static std::string schema(const Range& range) { return number_schema(false, range); }
};

template <>
struct Value<float> {
    static float read(const toml::node& node) { return static_cast<float>(Value<double>::read(node)); }
    static std::string write(float value) { return digits(value); }
    static std::string words() { return "number"; }
    static std::string schema(const Range& range) { return number_schema(false, range); }
};

template <>
struct Value<int> {
    static int read(const toml::node& node);
    static std::string write(int value) { return std::to_string(value); }
    static std::string words() { return "whole number"; }
    static std::string schema(const Range& range) { return number_schema(true, range); }
};

template <>
struct Value<std::uint32_t> {
    static std::uint32_t read(const toml::node& node);
    static std::string write(std::uint32_t value) { return std::to_string(value); }
    static std::string words() { return "whole number"; }
    static std::string schema(const Range& range) { return number_schema(true, range); }
};

template <>
struct Value<bool> {
    static bool read(const toml::node& node);
    static std::string write(bool value) { return value ? "true" : "false"; }
    static std::string words() { return "true or false"; }
    static std::string schema(const Range&) { return R"({"type":"boolean"})"; }
};

template <>
struct Value<std::string> {
    static std::string read(const toml::node& node);
    static std::string write(const std::string& value);
    static std::string words() { return "text"; }
    static std::string schema(const Range&) { return R"({"type":"string"})"; }
};

template <int N>
struct Value<Eigen::Matrix<double, N, 1>> {
    static Eigen::Matrix<double, N, 1> read(const toml::node& node) {
        const toml::array& array = array_of(node, N, words());
        Eigen::Matrix<double, N, 1> value;
        for (int i = 0; i < N; ++i) value(i) = Value<double>::read(array[i]);
        return value;
    }
    static std::string write(const Eigen::Matrix<double, N, 1>& value) {
        std::string text;
        for (int i = 0; i < N; ++i) text += (i ? ", " : "[") + digits(value(i));
        return text + "]";
    }
    static std::string words() { return N == 2 ? "[x, y]" : "[x, y, z]"; }
    static std::string schema(const Range& range) { return list_schema(number_schema(false, range), N, N); }
};

template <>
struct Value<render::Float3> {
    static render::Float3 read(const toml::node& node);
    static std::string write(const render::Float3& v);
    static std::string words() { return "[x, y, z]"; }
    static std::string schema(const Range& range) { return list_schema(number_schema(false, range), 3, 3); }
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
    static std::string words() { return "list of " + Value<T>::words(); }
    static std::string schema(const Range& range) { return list_schema(Value<T>::schema(range), 0, 0); }
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
    static std::string words() { return "[" + Value<T>::words() + ", " + Value<T>::words() + "]"; }
    static std::string schema(const Range& range) { return list_schema(Value<T>::schema(range), 2, 2); }
};

/// Whole numbers along x and along y, or one for both.
template <>
struct Value<std::array<int, 2>> {
    static std::array<int, 2> read(const toml::node& node);
    static std::string write(const std::array<int, 2>& v) { return fmt::format("[{}, {}]", v[0], v[1]); }
    static std::string words() { return "whole number or [along x, along y]"; }
    static std::string schema(const Range& range) {
        const std::string one = number_schema(true, range);
        return R"({"anyOf":[)" + one + "," + list_schema(one, 2, 2) + "]}";
    }
};

template <>
struct Value<DragDesc::Key> {
    static DragDesc::Key read(const toml::node& node);
    static std::string write(const DragDesc::Key& key) {
        return Value<Vec3>::write(Vec3(key.time, key.pixel.x(), key.pixel.y()));
    }
    static std::string words() { return "[time, x, y]"; }
    static std::string schema(const Range& range) { return list_schema(number_schema(false, range), 3, 3); }
};

/// "640x360" or [640, 360].
template <>
struct Value<PixelSize> {
    static PixelSize read(const toml::node& node);
    static std::string write(const PixelSize& s) { return fmt::format("[{}, {}]", s.width, s.height); }
    static std::string words() { return "\"WxH\" or [width, height]"; }
    static std::string schema(const Range& range) {
        return R"({"anyOf":[{"type":"string","pattern":"^[0-9]+x[0-9]+$"},)" +
               list_schema(number_schema(true, range), 2, 2) + "]}";
    }
};

/// "#rrggbb" or [r, g, b].
template <>
struct Value<Color> {
    static Color read(const toml::node& node);
    static std::string write(const Color& color) { return Value<Vec3>::write(color.srgb); }
    static std::string words() { return "\"#rrggbb\" or [r, g, b]"; }
    static std::string schema(const Range&) {
        return R"({"anyOf":[{"type":"string","pattern":"^#[0-9a-fA-F]{6}$"},)" +
               list_schema(number_schema(false, range(0.0, 1.0)), 3, 3) + "]}";
    }
};

template <>
struct Value<PicturePlace> {
    static PicturePlace read(const toml::node& node);
    static std::string write(const PicturePlace& p) { return Value<Vec3>::write(Vec3(p.x, p.y, p.radius)); }
    static std::string words() { return "[x, y] or [x, y, radius]"; }
    static std::string schema(const Range& range) { return list_schema(number_schema(false, range), 2, 3); }
};

/// A text with known words in braces.
struct Caption {
    /// The text; none for false.
    static std::optional<std::string> read(const toml::node& node);
    static std::string write(const std::optional<std::string>& text) {
        return text ? Value<std::string>::write(*text) : "false";
    }
};

/// The word of a list that a node holds, by its index.
std::size_t read_word(const toml::node& node, const std::vector<std::string>& words);

template <class E>
requires std::is_enum_v<E>
struct Value<E> {
    static std::vector<std::string> known() {
        std::vector<std::string> words;
        for (const auto& [value, name] : names_of(E{})) words.emplace_back(name);
        return words;
    }
    static E read(const toml::node& node) { return names_of(E{})[read_word(node, known())].value; }
    static std::string write(E value) {
        for (const auto& [each, name] : names_of(E{})) {
            if (each == value) return Value<std::string>::write(name);
        }
        return "";
    }
    static std::string words() { return "one of " + join(known()); }
    static std::string schema(const Range&) { return words_schema(known()); }
};

/// A list of names, each at most once.
template <class E>
requires std::is_enum_v<E>
struct Value<std::vector<E>> {
    static std::vector<E> read(const toml::node& node) {
        std::vector<E> values;
        for (const toml::node& entry : array_of(node, 0, "a list of names")) {
            const std::string part = fmt::format("[{}]", values.size());
            try {
                values.push_back(Value<E>::read(entry));
            } catch (const BadValue& bad) {
                throw BadValue{bad.what, part, entry.source()};
            }
            if (std::count(values.begin(), values.end(), values.back()) > 1)
                throw BadValue{"stands there twice", part, entry.source()};
        }
        return values;
    }
    static std::string write(const std::vector<E>& values) {
        std::string text;
        for (E value : values) text += (text.empty() ? "" : ", ") + Value<E>::write(value);
        return "[" + text + "]";
    }
    static std::string words() { return "list of " + join(Value<E>::known()); }
    static std::string schema(const Range&) { return list_schema(words_schema(Value<E>::known()), 0, 0); }
};

}  // namespace cloth::pipeline
