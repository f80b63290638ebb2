#include "pipeline/scene_file/field.h"

#include <algorithm>

#include "pipeline/formats/mesh_cache_file.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/formats/pattern.h"

namespace cloth::pipeline {

std::string unit_suffix(const Field& field) {
    return field.unit.empty() ? "" : " [" + field.unit + "]";
}

std::string suggestion(const std::string& key, const Fields& fields, const std::vector<std::string>& more) {
    std::vector<std::string> known = more;
    for (const Field& f : fields) known.push_back(f.key);
    const std::string near = nearest_word(key, known);
    if (near.empty()) return "known here: " + join(known);
    const auto f = std::find_if(fields.begin(), fields.end(), [&](const Field& g) { return g.key == near; });
    return fmt::format("did you mean \"{}\"{}?", near, f == fields.end() ? "" : unit_suffix(*f));
}

Field& FieldList::add(const char* key, const char* unit, const char* meaning, std::string words,
                      std::string schema) {
    Field f{.key = key, .unit = unit, .meaning = meaning};
    f.words = std::move(words);
    f.schema = std::move(schema);
    f.applies = applies_;
    fields_->push_back(std::move(f));
    return fields_->back();
}

void FieldList::operator()(const char* key, std::optional<std::string>& value, Words words,
                           const char* meaning) {
    const std::vector<std::string> known(words.begin(), words.end());
    Field& f = add(key, "", meaning, "one of " + join(known), words_schema(known));
    f.read = [&value, known](const toml::node& node) { value = known[read_word(node, known)]; };
    f.write = [&value] { return value ? Value<std::string>::write(*value) : std::string(); };
}

// ---------------------------------------------------------------- files

/// Its name is read; the file itself once all keys are known, by load().
Field& FieldList::add_file(const char* key, const char* meaning) {
    Field& f = add(key, "", meaning, "file", R"({"type":"string"})");
    const std::string full = path_ + "." + key;
    f.read = [files = files_, full](const toml::node& node) {
        (*files)[full] = Value<std::string>::read(node);
    };
    f.write = [files = files_, full] {
        const auto name = files->find(full);
        return name == files->end() ? std::string() : Value<std::string>::write(name->second);
    };
    return f;
}

namespace {

template <class Matrix>
std::string bytes_of(const Matrix& m) {
    return std::string(reinterpret_cast<const char*>(m.data()),
                       static_cast<std::size_t>(m.size()) * sizeof(*m.data()));
}

}  // namespace

void FieldList::operator()(const char* key, std::optional<MeshData>& mesh, const char* meaning) {
    Field& f = add_file(key, meaning);
    f.load = [&mesh](const std::filesystem::path& path) {
        LoadedMesh loaded = read_mesh(path);
        mesh = std::move(loaded.mesh);
        return loaded.notes;
    };
    f.content = [&mesh] {
        if (!mesh) return std::string();
        std::string bytes = bytes_of(mesh->positions) + bytes_of(mesh->triangles) + bytes_of(mesh->uv);
        for (const MeshPart& part : mesh->parts) {
            bytes += part.name + '\0';
            bytes += bytes_of(Eigen::Map<const Eigen::VectorXi>(
                part.triangles.data(), static_cast<Eigen::Index>(part.triangles.size())));
        }
        return bytes;
    };
}

void FieldList::operator()(const char* key, const MeshSource& source, const char* meaning) {
    (*this)(key, source.mesh, meaning);
    fields_->back().load = [source, read = fields_->back().load](const std::filesystem::path& path) {
        if (path.extension() != ".json") return read(path);
        LoadedMesh loaded = read_pattern(path, source.edge_length.value_or(usual_pattern_edge));
        source.mesh = std::move(loaded.mesh);
        return loaded.notes;
    };
}

void FieldList::operator()(const char* key, std::optional<Points>& points, const char* meaning) {
    Field& f = add_file(key, meaning);
    f.load = [&points](const std::filesystem::path& path) {
        LoadedMesh loaded = read_points(path);
        points = std::move(loaded.mesh.positions);
        return loaded.notes;
    };
    f.content = [&points] { return points ? bytes_of(*points) : std::string(); };
}

void FieldList::operator()(const char* key, std::shared_ptr<const render::Image>& image,
                           const char* meaning) {
    Field& f = add_file(key, meaning);
    f.load = [&image](const std::filesystem::path& path) {
        image = std::make_shared<const render::Image>(render::read_png(path));
        return std::vector<std::string>();
    };
    f.content = [&image] {
        return image ? fmt::format("{}x{} ", image->width, image->height) +
                           std::string(image->rgba.begin(), image->rgba.end())
                     : std::string();
    };
}

void FieldList::operator()(const char* key, std::shared_ptr<const MeshCache>& cache, const char* meaning) {
    Field& f = add_file(key, meaning);
    f.load = [&cache](const std::filesystem::path& path) {
        LoadedCache loaded = read_mesh_cache(path);
        cache = std::make_shared<const MeshCache>(std::move(loaded.cache));
        return loaded.notes;
    };
    f.content = [&cache] {
        std::string bytes;
        if (!cache) return bytes;
        for (const Points& frame : cache->frames) bytes += bytes_of(frame);
        bytes += bytes_of(
            Eigen::Map<const VecX>(cache->times.data(), static_cast<Eigen::Index>(cache->times.size())));
        return bytes + bytes_of(cache->triangles);
    };
}

// ---------------------------------------------------------------- references and choices

namespace {

std::vector<std::string> names_in(const Scene& scene, Listed list) {
    std::vector<std::string> names;
    if (list == Listed::cloth) {
        for (const ClothDesc& c : scene.cloths) names.push_back(c.name);
    } else {
        for (const ColliderDesc& c : scene.colliders) names.push_back(c.name);
    }
    return names;
}

/// The index that a name or number stands for.
int referred(const toml::node& node, const std::vector<std::string>& names, const char* what) {
    if (node.is_integer()) {
        const int index = Value<int>::read(node);
        if (index < 0 || static_cast<std::size_t>(index) >= names.size())
            throw BadValue{
                fmt::format("is {}; the scene has {} [[{}]], counted from 0", index, names.size(), what)};
        return index;
    }
    if (!node.is_string()) wrong_type(node, fmt::format("a {}'s name or its index", what));
    const std::string name = Value<std::string>::read(node);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<int>(found - names.begin());
    const std::string near = nearest_word(name, names);
    throw BadValue{fmt::format("there is no {} \"{}\"; {}", what, name,
                               !near.empty()   ? fmt::format("did you mean \"{}\"?", near)
                               : names.empty() ? "the scene has none"
                                               : "known: " + join(names))};
}

}  // namespace

void FieldList::operator()(const char* key, const Reference& reference, const char* meaning) {
    const char* what = reference.list == Listed::cloth ? "cloth" : "collider";
    Field& f = add(key, "", meaning, "name or index",
                   R"({"anyOf":[{"type":"string"},{"type":"integer","minimum":0}]})");
    f.read = [reference, what, scene = scene_](const toml::node& node) {
        const int index = referred(node, names_in(*scene, reference.list), what);
        if (reference.index) {
            *reference.index = index;
        } else {
            *reference.optional_index = index;
        }
    };
    f.write = [reference, scene = scene_]() -> std::string {
        const std::vector<std::string> names = names_in(*scene, reference.list);
        const std::optional<int> index = reference.index ? *reference.index : *reference.optional_index;
        if (!index) return "";
        return static_cast<std::size_t>(*index) < names.size() ? Value<std::string>::write(names[*index])
                                                               : std::to_string(*index);
    };
}

void FieldList::operator()(const char* key, const IntegratorChange& change, const char* meaning) {
    std::vector<std::string> known = Value<IntegratorKind>::known();
    known.insert(known.begin(), "toggle");
    Field& f = add(key, "", meaning, "one of " + join(known), words_schema(known));
    f.read = [change, known](const toml::node& node) {
        const std::size_t word = read_word(node, known);
        change.toggle = word == 0;
        if (word > 0) change.integrator = integrator_names[word - 1].value;
    };
    f.write = [change] {
        if (change.toggle) return std::string("\"toggle\"");
        return change.integrator ? Value<IntegratorKind>::write(*change.integrator) : std::string();
    };
}

void FieldList::operator()(const char* key, const CaptionText& caption, const char* meaning) {
    Field& f = add(key, "", meaning, "true, false or text", R"({"type":["boolean","string"]})");
    f.read = [caption](const toml::node& node) { caption.text = Caption::read(node); };
    f.write = [caption] { return Caption::write(caption.text); };
}

// ---------------------------------------------------------------- key frames

void read_inline(const toml::node& node, const Fields& fields) {
    const toml::table* table = node.as_table();
    if (!table)
        throw BadValue{"is " + type_name(node) + "; must be " + inline_words(fields), "", node.source()};
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
    if (!table->contains(fields[0].key))
        throw BadValue{fmt::format("has no {}{}", fields[0].key, unit_suffix(fields[0])), "", node.source()};
}

std::string write_inline(const Fields& fields) {
    std::string text;
    for (const Field& f : fields)
        if (const std::string value = f.write(); !value.empty())
            text += (text.empty() ? "{ " : ", ") + f.key + " = " + value;
    return text + " }";
}

std::string inline_words(const Fields& fields) {
    std::string text;
    for (const Field& f : fields) text += (text.empty() ? "{ " : ", ") + f.key;
    return text + " }";
}

std::string inline_schema(const Fields& fields) {
    std::string text;
    for (const Field& f : fields)
        text += fmt::format("{}\"{}\":{}", text.empty() ? "" : ",", f.key, f.schema);
    return fmt::format(
        R"({{"type":"object","properties":{{{}}},"required":["{}"],"additionalProperties":false}})", text,
        fields[0].key);
}

}  // namespace cloth::pipeline
