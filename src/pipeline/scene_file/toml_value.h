#pragma once
// How each type of value stands in a scene file: read from a TOML node, and written back.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "render/frame.h"
#include "sim/scene/scene.h"

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

/// The shortest digits that read back to the same bits, with a point or an exponent.
std::string digits(double value);

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

inline const toml::array& array_of(const toml::node& node, std::size_t size, const std::string& wanted) {
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
}  // namespace cloth::pipeline
