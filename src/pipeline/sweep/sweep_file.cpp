#include "pipeline/sweep/sweep_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>

#include "base/portable_math.h"
#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/scene_file/reader.h"
#include "pipeline/sweep/measures.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

inline constexpr EnumName<CellPictures> picture_names[] = {
    {CellPictures::all, "all"}, {CellPictures::last, "last"}, {CellPictures::none, "none"}};
constexpr std::span<const EnumName<CellPictures>> names_of(CellPictures) {
    return picture_names;
}

namespace {

/// What most sweeps have far fewer of.
constexpr int most_samples = 1'000'000;

/// Keys of the file's root that are values.
template <class V>
void describe(V& v, SweepFile& f, std::vector<std::string>& constraints) {
    v("version", f.version, "", range(0, 1000), "of the format: 1");
    v("scene", f.scene, "the base: a name, or a file relative to this one");
    v("description", f.description, "one line for the page of results");
    v("cell_name", f.cell_name, "of each cell: text with {key}, {list}, {sample}, {cell} filled in");
    v("variables", f.variables, "names for sampled or derived numbers that are no keys of the scene");
    v("constraints", constraints, "expressions; cells where one does not hold are left out");
}

template <class V>
void describe(V& v, ResultsDesc& r, std::vector<std::string>& columns) {
    v("measures", r.measures, "what is measured; default: all");
    v("columns", columns, "expressions of keys, told beside the measures");
    v("pictures", r.pictures, "of each cell: of all frames, the last, or none");
    v("movies", r.movies, "true: of each cell too");
    v("sheet", r.sheet, "one movie of all cells beside each other");
    v("pedestal_radius", r.pedestal_radius, "m", range(0.0, 1e6),
      "of what carries the cloth, for the drape coefficient; 0: nothing");
}

constexpr const char* distribution_words =
    "{ uniform = [low, high] }, { log_uniform = [low, high] }, { normal = [mean, deviation] }, "
    "{ integer = [low, high] } or { choice = [a, b, …] }";

SweepPlace place_of_node(const toml::source_region& region) {
    return {std::max<unsigned>(1, region.begin.line), std::max<unsigned>(1, region.begin.column)};
}

/// A value as TOML text; empty for a table or a date.
std::string text_of(const toml::node& node) {
    if (const toml::array* array = node.as_array()) {
        std::string text;
        for (const toml::node& each : *array) {
            const std::string part = text_of(each);
            if (part.empty()) return {};
            text += (text.empty() ? "" : ", ") + part;
        }
        return "[" + text + "]";
    }
    if (const auto* value = node.as_integer()) return std::to_string(value->get());
    if (const auto* value = node.as_floating_point()) return digits(value->get());
    if (const auto* value = node.as_boolean()) return value->get() ? "true" : "false";
    if (const auto* value = node.as_string()) return Value<std::string>::write(value->get());
    return {};
}

class SweepReader {
  public:
    SweepReader(SweepFile& file) : file_(file), reader_(file.path.string(), file.path.parent_path()) {}

    void read() {
        reader_.parse(file_.text);
        read_head();
        if (const toml::table* table = reader_.table("results")) read_results(*table);
        for (const auto& [key, node] : leaves("set", {})) file_.set.push_back({key, setting(key, *node)});
        for (const auto& [key, node] : leaves("grid", {"from"})) file_.grid.push_back(grid_key(key, *node));
        read_list();
        read_samples();
        for (const auto& [key, node] : leaves("derived", {}))
            file_.derived.push_back(derived_key(key, *node));
        refuse_doubled_keys();
        if (file_.grid.empty() && file_.list.empty() && file_.samples == 0)
            fail(reader_.root(), "", "sweeps over nothing; give a [grid], a [[list]] or [samples]");
    }

  private:
    using Leaf = std::pair<SweptKey, const toml::node*>;

    [[noreturn]] void fail(const SweepPlace& place, const std::string& key,
                           const std::string& message) const {
        refuse_scene(fmt::format("{}: {}{}{}", file_.at(place), key, key.empty() ? "" : ": ", message));
    }
    [[noreturn]] void fail(const toml::node& node, const std::string& key, const std::string& message) const {
        fail(place_of_node(node.source()), key, message);
    }

    /// All that is no table in the table `name` of the root and its tables, in the order of the file. A table
    /// with one of the keys `ends` counts as a value.
    std::vector<Leaf> leaves(const std::string& name, const std::vector<std::string>& ends) {
        std::vector<Leaf> found;
        if (const toml::table* table = reader_.table(name)) collect(*table, "", ends, found);
        std::stable_sort(found.begin(), found.end(), [](const Leaf& a, const Leaf& b) {
            return std::pair(a.first.place.line, a.first.place.column) <
                   std::pair(b.first.place.line, b.first.place.column);
        });
        return found;
    }
    void collect(const toml::table& table, const std::string& path, const std::vector<std::string>& ends,
                 std::vector<Leaf>& found) const {
        for (const auto& [key, node] : table) {
            const std::string full = (path.empty() ? "" : path + ".") + std::string(key.str());
            const toml::table* inner = node.as_table();
            const bool value = inner && std::any_of(ends.begin(), ends.end(), [&](const std::string& end) {
                                   return inner->contains(end);
                               });
            if (inner && !value)
                collect(*inner, full, ends, found);
            else
                found.push_back({{full, place_of_node(key.source())}, &node});
        }
    }

    std::string setting(const SweptKey& key, const toml::node& node) const {
        std::string text = text_of(node);
        if (text.empty())
            fail(node, key.key, "is " + type_name(node) + "; must be a value or a list of them");
        return text;
    }

    Expression expression(const toml::node& node, const std::string& key, const std::string& text) const {
        try {
            return Expression(text);
        } catch (const std::invalid_argument& error) {
            fail(node, key, fmt::format("\"{}\" {}", text, error.what()));
        }
    }

    void read_head() {
        std::vector<std::string> constraints;
        Fields fields;
        FieldList list(fields);
        describe(list, file_, constraints);
        const toml::table& root = reader_.root();
        reader_.read(root, "", fields, {"set", "grid", "list", "samples", "derived", "results"});
        if (!root.contains("version")) fail(root, "version", "is missing; write version = 1");
        if (file_.version != 1)
            fail(*root.get("version"), "version",
                 fmt::format("is {}; this program reads version 1", file_.version));
        if (file_.scene.empty())
            fail(root, "scene", "is missing; name the scene that is swept, scene = \"cusick\"");
        if (file_.scene.ends_with(".toml")) file_.scene = reader_.find_file(file_.scene).string();
        for (const std::string& name : file_.variables)
            if (name.empty() ||
                name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
                                       "0123456789") != name.npos ||
                (name[0] >= '0' && name[0] <= '9'))
                fail(*root.get("variables"), "variables",
                     fmt::format("has \"{}\"; a name has letters, digits and _, and begins with a letter",
                                 name));
        for (std::size_t i = 0; i < constraints.size(); ++i) {
            const toml::node& node = *root.get_as<toml::array>("constraints")->get(i);
            file_.constraints.push_back(
                {place_of_node(node.source()), expression(node, "constraints", constraints[i])});
        }
    }

    void read_results(const toml::table& table) {
        std::vector<std::string> columns;
        Fields fields;
        FieldList list(fields);
        describe(list, file_.results, columns);
        reader_.read(table, "results", fields);
        std::vector<std::string> known;
        for (const Measure& measure : measures()) known.emplace_back(measure.name);
        std::vector<std::string>& chosen = file_.results.measures;
        if (chosen.empty()) chosen = known;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            if (std::find(known.begin(), known.end(), chosen[i]) != known.end()) continue;
            const std::string near = nearest_word(chosen[i], known);
            fail(*table.get_as<toml::array>("measures")->get(i), "results.measures",
                 fmt::format("has \"{}\"; {}one of {}", chosen[i],
                             near.empty() ? "must be " : "did you mean \"" + near + "\"? ", join(known)));
        }
        for (std::size_t i = 0; i < columns.size(); ++i)
            file_.columns.emplace_back(columns[i], expression(*table.get_as<toml::array>("columns")->get(i),
                                                              "results.columns", columns[i]));
    }

    GridKey grid_key(const SweptKey& key, const toml::node& node) {
        if (const toml::table* table = node.as_table()) return {key, spaced_values(key.key, *table)};
        const toml::array* array = node.as_array();
        if (!array || array->empty())
            fail(node, key.key,
                 "is " + type_name(node) +
                     "; must be a list of values, or { from = a, to = b, count = n }, with scale = \"log\"");
        GridKey grid{key, {}};
        for (const toml::node& each : *array) grid.values.push_back(setting(key, each));
        return grid;
    }

    /// { from = a, to = b, count = n, scale = "linear" }, to six digits between the ends.
    std::vector<std::string> spaced_values(const std::string& path, const toml::table& table) {
        double from = 0, to = 0;
        int count = 0;
        std::string scale = "linear";
        Fields fields;
        FieldList list(fields);
        list("from", from, "", any, "");
        list("to", to, "", any, "");
        list("count", count, "", range(2, most_samples), "");
        list("scale", scale, "");
        reader_.read(table, path, fields);
        for (const char* name : {"from", "to", "count"})
            if (!table.contains(name)) fail(table, path, fmt::format("has no {}", name));
        if (scale != "linear" && scale != "log")
            fail(*table.get("scale"), path + ".scale",
                 fmt::format("is \"{}\"; must be one of linear, log", scale));
        if (scale == "log" && !(from > 0 && to > 0))
            fail(table, path, "both ends of a logarithmic scale must be greater than 0");
        std::vector<std::string> values;
        for (int i = 0; i < count; ++i) {
            const double t = static_cast<double>(i) / (count - 1);
            const double exact =
                scale == "log"
                    ? portable_exp(portable_log(from) + t * (portable_log(to) - portable_log(from)))
                    : from + t * (to - from);
            values.push_back(i == 0           ? text_of(*table.get("from"))
                             : i == count - 1 ? text_of(*table.get("to"))
                                              : number_value(six_digits(exact)));
        }
        return values;
    }

    static double six_digits(double value) {
        const std::string text = fmt::format("{:.6g}", value);
        std::from_chars(text.data(), text.data() + text.size(), value);
        return value;
    }

    /// A whole number without a point, so that keys that are whole numbers take it.
    static std::string number_value(double value) {
        return value == std::floor(value) && std::abs(value) < 1e15
                   ? std::to_string(static_cast<std::int64_t>(value))
                   : digits(value);
    }

    void read_list() {
        for (const toml::table* table : reader_.list("list")) {
            ListEntry entry;
            std::vector<Leaf> found;
            collect(*table, "", {}, found);
            for (const auto& [key, node] : found) {
                if (key.key != "name") {
                    entry.settings.push_back({key, setting(key, *node)});
                } else if (const auto* text = node->as_string()) {
                    entry.name = text->get();
                } else {
                    fail(*node, "list.name", "is " + type_name(*node) + "; must be a text");
                }
            }
            if (entry.settings.empty()) fail(*table, "list", "sets no key");
            file_.list.push_back(std::move(entry));
        }
    }

    void read_samples() {
        const toml::table* table = reader_.table("samples");
        if (!table) return;
        Fields fields;
        FieldList list(fields);
        list("count", file_.samples, "", range(1, most_samples), "");
        list("seed", file_.seed, "", range(0.0, 4294967295.0), "");
        std::vector<std::string> others;
        for (const auto& [key, node] : *table)
            if (key != "count" && key != "seed") others.emplace_back(key.str());
        reader_.read(*table, "samples", fields, others);
        if (!table->contains("count")) fail(*table, "samples", "has no count");
        for (const auto& [key, node] :
             leaves("samples", {"uniform", "log_uniform", "normal", "integer", "choice"})) {
            if (key.key == "count" || key.key == "seed") continue;
            if (!node->is_table())
                fail(*node, key.key,
                     "is " + type_name(*node) + "; must be a distribution: " + distribution_words);
            file_.sampled.push_back({key, distribution(key.key, *node->as_table())});
        }
        if (file_.sampled.empty())
            fail(*table, "samples",
                 std::string("samples no key; write cloth.fabric.bending = ") + distribution_words);
    }

    Distribution distribution(const std::string& path, const toml::table& table) {
        Distribution d;
        std::optional<Vec2> uniform, log_uniform, normal;
        std::optional<std::array<int, 2>> integer;
        std::optional<double> least, greatest;
        Fields fields;
        FieldList list(fields);
        list("uniform", uniform, "", any, "");
        list("log_uniform", log_uniform, "", any, "");
        list("normal", normal, "", any, "");
        list("integer", integer, "", any, "");
        list("min", least, "", any, "");
        list("max", greatest, "", any, "");
        list("weights", d.weights, "", range(0.0, 1e12), "");
        reader_.read(table, path, fields, {"choice"});
        const toml::node* choice = table.get("choice");
        if (uniform.has_value() + log_uniform.has_value() + normal.has_value() + integer.has_value() +
                (choice != nullptr) !=
            1)
            fail(table, path, std::string("must be one distribution: ") + distribution_words);
        const auto span = [&](DistributionKind kind, double low, double high) {
            d.kind = kind;
            d.low = low;
            d.high = high;
            if (!(low <= high)) fail(table, path, fmt::format("goes from {:g} down to {:g}", low, high));
        };
        if (uniform) span(DistributionKind::uniform, uniform->x(), uniform->y());
        if (log_uniform) {
            span(DistributionKind::log_uniform, log_uniform->x(), log_uniform->y());
            if (!(d.low > 0)) fail(table, path, "both ends of log_uniform must be greater than 0");
        }
        if (integer) span(DistributionKind::integer, (*integer)[0], (*integer)[1]);
        if (normal) {
            d.kind = DistributionKind::normal;
            d.mean = normal->x();
            d.deviation = normal->y();
            if (!(d.deviation >= 0))
                fail(table, path, fmt::format("has the deviation {:g}; must be at least 0", d.deviation));
            d.low_said = least.has_value();
            d.high_said = greatest.has_value();
            d.low = least.value_or(-HUGE_VAL);
            d.high = greatest.value_or(HUGE_VAL);
            if (!(d.low <= d.high)) fail(table, path, fmt::format("has the min {:g} above the max", d.low));
        } else if (least || greatest) {
            fail(table, path, "min and max are for normal; other distributions have ends");
        }
        if (choice) {
            const toml::array* array = choice->as_array();
            if (!array || array->empty())
                fail(*choice, path + ".choice", "is " + type_name(*choice) + "; must be a list of values");
            d.kind = DistributionKind::choice;
            for (const toml::node& each : *array) {
                d.choices.push_back(text_of(each));
                if (d.choices.back().empty())
                    fail(each, path + ".choice", "has " + type_name(each) + "; must be values");
            }
        }
        if (!d.weights.empty() && (!choice || d.weights.size() != d.choices.size()))
            fail(*table.get("weights"), path + ".weights", "must be one number for each choice");
        if (!d.weights.empty() && *std::max_element(d.weights.begin(), d.weights.end()) <= 0)
            fail(*table.get("weights"), path + ".weights", "must not all be 0");
        return d;
    }

    DerivedKey derived_key(const SweptKey& key, const toml::node& node) const {
        DerivedKey derived{key, node.is_array(), {}};
        const auto add = [&](const toml::node& part) {
            if (const auto* text = part.as_string())
                derived.parts.push_back(expression(part, key.key, text->get()));
            else if (part.is_number())
                derived.parts.push_back(expression(part, key.key, text_of(part)));
            else
                fail(part, key.key,
                     "is " + type_name(part) + "; must be an expression, \"0.6 * cloth.fabric.bending\"");
        };
        if (const toml::array* array = node.as_array())
            for (const toml::node& part : *array) add(part);
        else
            add(node);
        return derived;
    }

    void refuse_doubled_keys() const {
        std::set<std::string> taken;
        const auto take = [&](const SweptKey& key) {
            if (!taken.insert(key.key).second)
                fail(key.place, key.key, "is given a value twice; say it in one table alone");
        };
        for (const auto& each : file_.set) take(each);
        for (const auto& each : file_.grid) take(each);
        std::set<std::string> listed;
        for (const ListEntry& entry : file_.list)
            for (const Setting& each : entry.settings)
                if (listed.insert(each.key).second) take(each);
        for (const auto& each : file_.sampled) take(each);
        for (const auto& each : file_.derived) take(each);
    }

    SweepFile& file_;
    Reader reader_;
};

}  // namespace

bool SweepFile::is_variable(const std::string& key) const {
    return std::find(variables.begin(), variables.end(), key) != variables.end();
}

std::string SweepFile::at(const SweepPlace& place) const {
    return fmt::format("{}:{}:{}", path.string(), place.line, place.column);
}

SweepFile load_sweep(const fs::path& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) refuse_scene(path.string() + ": there is no such file of a sweep");
    if (fs::is_directory(path, ignored))
        refuse_scene(path.string() + ": is a folder; a sweep is a .toml file");
    return parse_sweep(read_file(path), path);
}

SweepFile parse_sweep(const std::string& text, const fs::path& path) {
    SweepFile file;
    file.name = path.stem().string();
    file.path = path;
    file.text = text;
    for (const Measure& measure : measures()) file.results.measures.emplace_back(measure.name);
    SweepReader(file).read();
    return file;
}

}  // namespace cloth::pipeline
