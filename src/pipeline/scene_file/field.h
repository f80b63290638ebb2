#pragma once
// One key of a table of a scene file, whatever its type: how it is read into its place, written back and told
// of. FieldList is the visitor of describe() that makes them.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/scene_file/picture_schema.h"
#include "pipeline/scene_file/toml_value.h"

namespace cloth::pipeline {

struct Field {
    std::string key, unit, meaning;
    std::string words;    ///< what a file has to hold
    std::string range;    ///< of its numbers; "": any
    std::string schema;   ///< the same two as a JSON Schema
    bool applies = true;  ///< false: not written, other keys take its place
    std::function<void(const toml::node&)> read;
    std::function<std::string()> write;  ///< "": not set

    // Of a file alone: reads it and returns notes for the user, and what was read.
    std::function<std::vector<std::string>(const std::filesystem::path&)> load;
    std::function<std::string()> content;
};
using Fields = std::vector<Field>;

/// " [m]", or nothing.
std::string unit_suffix(const Field& field);

/// "known here: …" of the fields and `more` keys, or the nearest of them.
std::string suggestion(const std::string& key, const Fields& fields, const std::vector<std::string>& more);

/// Throws BadValue where a number of `value` lies out of the range.
template <class T>
void check_range(const T& value, const Range& range, const std::string& unit) {
    for_each_number(value, [&](double number) {
        if (!range.holds(number)) throw BadValue{.what = range.refusal(number, unit), .unit_said = true};
    });
}

/// Where a value stands: a field, an optional one, or one inside an optional struct. All of them copy.
template <class T>
struct Place {
    using Type = T;
    T* field;
    bool given() const { return true; }
    const T& get() const { return *field; }
    void set(const T& value) const { *field = value; }
};
template <class T>
struct OptionalPlace {
    using Type = T;
    std::optional<T>* field;
    bool given() const { return field->has_value(); }
    const T& get() const { return **field; }
    void set(const T& value) const { *field = value; }
    void reset() const { field->reset(); }
};
template <class S, class T>
struct InsidePlace {
    using Type = T;
    Inside<S, T> field;
    bool given() const { return field.has_value(); }
    const T& get() const { return *field; }
    void set(const T& value) const { field.set(value); }
};
template <class T>
Place<T> place_of(T& field) {
    return {&field};
}
template <class T>
OptionalPlace<T> place_of(std::optional<T>& field) {
    return {&field};
}
template <class S, class T>
InsidePlace<S, T> place_of(Inside<S, T>& field) {
    return {field};
}

class FieldList {
  public:
    /// Puts fields into `fields`. The scene has the names that references mean; `files` the names of files,
    /// by the dotted key that begins with `path`. Key frames need none of these.
    explicit FieldList(Fields& fields, const Scene* scene = nullptr, FileNames* files = nullptr)
        : fields_(&fields), scene_(scene), files_(files) {}

    template <class T>
    void operator()(const char* key, T&& value, const char* unit, const Range& range, const char* meaning) {
        const auto place = place_of(value);
        using Type = typename decltype(place)::Type;
        Field& f = add(key, unit, meaning, Value<Type>::words(), Value<Type>::schema(range));
        f.range = range.brief();
        f.read = [place, range, unit](const toml::node& node) {
            if constexpr (std::is_integral_v<Type>) {  // told by the key's range, not by the type's
                if (node.is_integer()) check_range(*node.value<std::int64_t>(), range, unit);
            }
            const Type read = Value<Type>::read(node);
            if constexpr (requires { place.reset(); }) {
                if constexpr (std::is_arithmetic_v<Type>) {
                    if (range.zero_is_none && read == 0) return place.reset();
                }
            }
            check_range(read, range, unit);
            place.set(read);
        };
        f.write = [place, none = std::string(range.zero_is_none ? "0.0" : "")] {
            return place.given() ? Value<Type>::write(place.get()) : none;
        };
    }
    template <class T>
    void operator()(const char* key, T& value, const char* meaning) {
        const auto place = place_of(value);
        using Type = typename decltype(place)::Type;
        Field& f = add(key, "", meaning, Value<Type>::words(), Value<Type>::schema(any));
        f.read = [place](const toml::node& node) { place.set(Value<Type>::read(node)); };
        f.write = [place] { return place.given() ? Value<Type>::write(place.get()) : std::string(); };
    }
    void operator()(const char* key, std::optional<std::string>& value, Words words, const char* meaning);
    void operator()(const char* key, std::optional<MeshData>& mesh, const char* meaning);
    void operator()(const char* key, const MeshSource& source, const char* meaning);
    void operator()(const char* key, std::optional<Points>& points, const char* meaning);
    void operator()(const char* key, std::shared_ptr<const render::Image>& image, const char* meaning);
    void operator()(const char* key, std::shared_ptr<const MeshCache>& cache, const char* meaning);
    void operator()(const char* key, const Reference& reference, const char* meaning);
    void operator()(const char* key, const IntegratorChange& change, const char* meaning);
    void operator()(const char* key, const CaptionText& caption, const char* meaning);

    template <class F>
    void when(bool applies, F&& keys) {
        const bool outer = applies_;
        applies_ = applies_ && applies;
        keys();
        applies_ = outer;
    }

  protected:
    Field& add(const char* key, const char* unit, const char* meaning, std::string words, std::string schema);
    Field& add_file(const char* key, const char* meaning);

    Fields* fields_;
    const Scene* scene_;
    FileNames* files_;
    std::string path_;  ///< of the table; "": the root
    bool applies_ = true;
};

// ---------------------------------------------------------------- key frames

/// An inline table that has a time.
template <class T>
concept KeyFrame = requires(T key, FieldList list) {
    describe(list, key);
    key.time;
};

template <class T>
Fields fields_of(T& desc) {
    Fields fields;
    FieldList list(fields);
    describe(list, desc);
    return fields;
}

/// Reads an inline table by fields of which the first is required.
void read_inline(const toml::node& node, const Fields& fields);
std::string write_inline(const Fields& fields);
std::string inline_words(const Fields& fields);
std::string inline_schema(const Fields& fields);

template <KeyFrame T>
struct Value<T> {
    static T read(const toml::node& node) {
        T key;
        read_inline(node, fields_of(key));
        return key;
    }
    static std::string write(T key) { return write_inline(fields_of(key)); }
    static std::string words() {
        T key;
        return inline_words(fields_of(key));
    }
    static std::string schema(const Range&) {
        T key;
        return inline_schema(fields_of(key));
    }
};

}  // namespace cloth::pipeline
