#include "pipeline/sweep/cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/run/fingerprints.h"
#include "pipeline/run/plan.h"
#include "pipeline/scene_file/reader.h"
#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t most_cells = 1'000'000;
constexpr std::size_t longest_name = 120;  // of a folder; file systems take 255 bytes

/// What a TOML text holds.
toml::table parsed(const std::string& text) {
    return toml::parse("v = " + text);
}

double number_of(const toml::node* node) {
    if (!node || !node->is_number()) return none;
    return node->value<double>().value_or(none);
}

double number_of(const std::string& text) {
    if (text.empty()) return none;
    const toml::table table = parsed(text);
    return number_of(table.get("v"));
}

/// As it stands in a name: a text without its quotes, a number to four digits.
std::string short_text(const std::string& text, bool in_full) {
    const toml::table table = parsed(text);
    const toml::node* node = table.get("v");
    if (const auto* word = node->as_string()) return word->get();
    if (const auto* value = node->as_floating_point(); value && !in_full)
        return fmt::format("{:.4g}", value->get());
    return text;
}

/// What a folder may be called everywhere, and an address needs no escape for.
std::string as_name(const std::string& text) {
    std::string name;
    for (const char c : text) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                           c == '.' || c == '_' || c == '+' || c == '=' || c == '-';
        if (plain)
            name += c;
        else if (c != '[' && c != ']' && c != ' ')
            name += '-';
    }
    while (!name.empty() && name.front() == '.') name.erase(0, 1);
    return name;
}

/// "cloth.fabric.bending" as values_of() has it: "cloth[0].fabric.bending".
std::string full_key(const std::string& key) {
    const std::size_t end = key.find_first_of(".[");
    if (end == key.npos || key[end] == '[') return key;
    const std::string table = key.substr(0, end);
    const bool listed =
        table == "light" || std::any_of(root_tables().begin(), root_tables().end(),
                                        [&](const RootTable& t) { return t.listed && t.name == table; });
    return listed ? table + "[0]" + key.substr(end) : key;
}

/// The numbers that expressions ask for: of the cell itself, then of its scene.
class Names {
  public:
    explicit Names(const SweepFile& sweep) : sweep_(sweep) {}

    void add(const CellValue& value) { own_[full_key(value.key)] = value; }
    bool has(const std::string& name) const { return find_own(name).has_value(); }
    bool has_all(const Expression& expression) const {
        return std::all_of(expression.names().begin(), expression.names().end(),
                           [&](const std::string& name) { return has(name); });
    }
    void use_scene(std::map<std::string, std::string> values) { scene_ = std::move(values); }
    bool knows_scene() const { return !scene_.empty(); }

    double at(const std::string& name) const {
        if (const auto own = find_own(name)) return require_number(name, *own);
        const std::string key = full_key(name);
        if (const auto value = element(scene_, key)) {
            if (value->empty()) throw std::invalid_argument(fmt::format("uses {}, which is not set", name));
            return require_number(name, *value);
        }
        std::vector<std::string> known = sweep_.variables;
        for (const auto& [each, value] : scene_) known.push_back(each);
        const std::string near = nearest_word(key, known);
        throw std::invalid_argument(fmt::format("uses {}, which is no key of the scene and no variable{}",
                                                name, near.empty() ? "" : "; did you mean " + near + "?"));
    }

  private:
    /// The TOML text under a key, or of entry i of the list under "key[i]".
    static std::optional<std::string> element(const std::map<std::string, std::string>& values,
                                              const std::string& key) {
        if (const auto found = values.find(key); found != values.end()) return found->second;
        const std::size_t bracket = key.rfind('[');
        if (!key.ends_with(']') || bracket == key.npos) return std::nullopt;
        const auto found = values.find(key.substr(0, bracket));
        if (found == values.end() || found->second.empty()) return std::nullopt;
        const toml::table table = parsed(found->second);
        const toml::array* array = table.get_as<toml::array>("v");
        const toml::node* node =
            array ? array->get(std::strtoul(key.c_str() + bracket + 1, nullptr, 10)) : nullptr;
        if (!node || !node->is_number()) return std::nullopt;
        return digits(number_of(node));
    }
    std::optional<std::string> find_own(const std::string& name) const {
        std::map<std::string, std::string> texts;
        const std::string key = full_key(name);
        for (const std::string& each : {key, key.substr(0, key.rfind('['))})
            if (const auto found = own_.find(each); found != own_.end()) texts[each] = found->second.text;
        return element(texts, key);
    }
    static double require_number(const std::string& name, const std::string& text) {
        const double number = number_of(text);
        if (std::isnan(number))
            throw std::invalid_argument(fmt::format("uses {}, which is {} and no number", name, text));
        return number;
    }

    const SweepFile& sweep_;
    std::map<std::string, CellValue> own_;
    std::map<std::string, std::string> scene_;
};

class CellMaker {
  public:
    explicit CellMaker(const SweepFile& sweep) : sweep_(sweep) {
        for (const GridKey& key : sweep.grid) add_key(key.key);
        for (const ListEntry& entry : sweep.list)
            for (const Setting& setting : entry.settings) add_key(setting.key);
        for (const SampledKey& key : sweep.sampled) add_key(key.key);
        for (const DerivedKey& key : sweep.derived) add_key(key.key);
        for (const GridKey& key : sweep.grid) {
            std::set<std::string> texts;
            for (const std::string& value : key.values) texts.insert(as_name(short_text(value, false)));
            in_full_.push_back(texts.size() < key.values.size());
        }
    }

    SweepCells make() {
        try {
            load_scene(sweep_.scene);
        } catch (const Error& error) {
            throw Error(error.code, fmt::format("{}: scene: {}", sweep_.path.string(), error.what()));
        }
        std::int64_t count = 1;
        const auto times = [&](std::size_t n) {
            count *= static_cast<std::int64_t>(std::max<std::size_t>(n, 1));
            if (count > most_cells)
                refuse_scene(fmt::format("{}: has more than {} cells", sweep_.path.string(), most_cells));
        };
        for (const GridKey& key : sweep_.grid) times(key.values.size());
        times(sweep_.list.size());
        times(static_cast<std::size_t>(sweep_.samples));
        result_.cells.reserve(static_cast<std::size_t>(count));
        for (std::int64_t i = 0; i < count; ++i) add_cell(i);
        if (result_.cells.empty()) refuse_scene(sweep_.path.string() + ": constraints leave no cell");
        return std::move(result_);
    }

  private:
    void add_key(const std::string& key) {
        if (std::find(result_.keys.begin(), result_.keys.end(), key) == result_.keys.end())
            result_.keys.push_back(key);
    }

    static CellValue value(const SweptKey& key, const std::string& text) {
        return {key.key, text, number_of(text), key.place};
    }

    /// Cell number `index` of all: the samples run fastest, the first key of the grid slowest.
    void add_cell(std::int64_t index) {
        Cell cell;
        std::vector<CellValue> values;
        std::vector<std::string> parts(sweep_.grid.size());
        std::string entry_name, sample_name;
        std::int64_t rest = index;
        if (sweep_.samples > 0) {
            cell.sample = rest % sweep_.samples;
            rest /= sweep_.samples;
            sample_name = fmt::format("s{:04d}", cell.sample);
        }
        const ListEntry* entry = nullptr;
        if (!sweep_.list.empty()) {
            entry = &sweep_.list[static_cast<std::size_t>(rest) % sweep_.list.size()];
            rest /= static_cast<std::int64_t>(sweep_.list.size());
            entry_name = entry->name;
        }
        for (std::size_t g = sweep_.grid.size(); g-- > 0;) {
            const GridKey& key = sweep_.grid[g];
            const std::string& text = key.values[static_cast<std::size_t>(rest) % key.values.size()];
            rest /= static_cast<std::int64_t>(key.values.size());
            values.insert(values.begin(), value(key, text));
            parts[g] = label(key.key) + "=" + short_text(text, in_full_[g]);
        }
        if (entry) {
            std::string texts;
            for (const Setting& setting : entry->settings) {
                values.push_back(value(setting, setting.value));
                texts +=
                    (texts.empty() ? "" : "_") + label(setting.key) + "=" + short_text(setting.value, false);
            }
            if (entry_name.empty()) entry_name = texts;
            parts.push_back(entry_name);
        }
        for (const SampledKey& key : sweep_.sampled) {
            try {
                values.push_back(
                    value(key, sample_text(key.distribution, sweep_.seed, key.key, cell.sample)));
            } catch (const std::runtime_error& error) {
                refuse(key.place, key.key, error.what());
            }
        }
        if (!sample_name.empty()) parts.push_back(sample_name);

        Names names(sweep_);
        for (const CellValue& each : values) names.add(each);
        // Of keys of the scene that nothing here sets, what it says.
        cell.values = values;
        cell.name = as_name(join(parts, "_"));
        for (const DerivedKey& key : sweep_.derived) {
            std::string text;
            for (const Expression& part : key.parts) {
                know(part, names, cell);
                const double number = evaluated(part, names, key.place, key.key);
                text += (text.empty() ? "" : ", ") + (number == std::floor(number) && std::abs(number) < 1e15
                                                          ? std::to_string(static_cast<std::int64_t>(number))
                                                          : digits(number));
            }
            cell.values.push_back(value(key, key.list ? "[" + text + "]" : text));
            names.add(cell.values.back());
        }
        // Of what breaks a constraint nothing more is asked, where that needs no scene.
        std::vector<const Constraint*> late;
        for (const Constraint& constraint : sweep_.constraints) {
            if (!names.has_all(constraint.condition))
                late.push_back(&constraint);
            else if (evaluated(constraint.condition, names, constraint.place, "constraints") == 0)
                return leave_out();
        }
        set_overrides(cell);
        const SceneFile file = load(cell);
        if (!late.empty() || !sweep_.columns.empty()) names.use_scene(values_of(file));
        for (const Constraint* constraint : late)
            if (evaluated(constraint->condition, names, constraint->place, "constraints") == 0)
                return leave_out();
        for (const auto& [text, expression] : sweep_.columns)
            cell.columns.push_back(evaluated(expression, names, {}, "results.columns"));
        finish(std::move(cell), file, entry_name, sample_name);
    }

    void leave_out() { ++result_.left_out; }

    /// Makes sure that an expression's names are known, if need be from the scene as the cell has it so far.
    void know(const Expression& expression, Names& names, Cell& cell) const {
        if (names.knows_scene() || names.has_all(expression)) return;
        Cell so_far = cell;
        set_overrides(so_far);
        names.use_scene(values_of(load(so_far)));
    }

    double evaluated(const Expression& expression, const Names& names, const SweepPlace& place,
                     const std::string& key) const {
        try {
            return expression.at([&](const std::string& name) { return names.at(name); });
        } catch (const std::invalid_argument& error) {
            refuse(place, key, fmt::format("\"{}\" {}", expression.text(), error.what()));
        }
    }

    [[noreturn]] void refuse(const SweepPlace& place, const std::string& key, const std::string& what) const {
        refuse_scene(fmt::format("{}: {}: {}", sweep_.at(place), key, what));
    }

    /// The last part of a key, or as many more as tell it from the others.
    std::string label(const std::string& key) const {
        for (std::size_t at = key.rfind('.'); at != key.npos && at > 0; at = key.rfind('.', at - 1)) {
            const std::string tail = key.substr(at);
            if (std::count_if(result_.keys.begin(), result_.keys.end(),
                              [&](const std::string& other) { return ("." + other).ends_with(tail); }) == 1)
                return tail.substr(1);
        }
        return key;
    }

    void set_overrides(Cell& cell) const {
        cell.overrides.clear();
        cell.overrides.emplace_back("output.size=[320, 180]", "output.size");
        std::vector<std::pair<std::string, Override>> list;
        for (const Setting& each : sweep_.set)
            list.emplace_back(each.key,
                              Override(each.key + "=" + each.value, sweep_.at(each.place) + ": [set]"));
        for (const CellValue& each : cell.values)
            if (!sweep_.is_variable(each.key))
                list.emplace_back(each.key, Override(each.key + "=" + each.text,
                                                     sweep_.at(each.place) + ": cell " + cell.name));
        // A fabric's name before a part of it.
        const auto depth = [](const std::string& key) { return std::count(key.begin(), key.end(), '.'); };
        std::stable_sort(list.begin(), list.end(),
                         [&](const auto& a, const auto& b) { return depth(a.first) < depth(b.first); });
        for (auto& [key, setting] : list) {
            setting.refusal = ExitCode::invalid_scene;
            cell.overrides.push_back(std::move(setting));
        }
    }

    SceneFile load(const Cell& cell) const {
        try {
            return load_cell(sweep_, cell);
        } catch (const Error& error) {
            // What is not one key's fault names the scene's file alone.
            const std::string line = error.what();
            if (line.starts_with(sweep_.path.string() + ":")) throw;
            throw Error(error.code, fmt::format("{}: cell {}: {}", sweep_.path.string(), cell.name, line));
        }
    }

    void finish(Cell cell, const SceneFile& file, const std::string& entry_name,
                const std::string& sample_name) {
        if (!sweep_.cell_name.empty()) cell.name = filled(cell, entry_name, sample_name);
        if (cell.name.empty() || cell.name.size() > longest_name)
            refuse_scene(
                fmt::format("{}: a cell's name, \"{}\", has {} letters; give cell_name, a pattern "
                            "with 1 to {}",
                            sweep_.path.string(), cell.name, cell.name.size(), longest_name));
        const auto [first, is_new] = places_.emplace(cell.name, result_.cells.size());
        if (!is_new)
            refuse_scene(fmt::format(
                "{}: two cells are named \"{}\": {}, and {}; give cell_name, a pattern "
                "that tells them apart, or names in [[list]]",
                sweep_.path.string(), cell.name, words(result_.cells[first->second]), words(cell)));
        const ResultsDesc& results = sweep_.results;
        cell.key = fingerprint(fmt::format("{}\n{}\n{} {} {:a}", scene_key(file), maker(),
                                           static_cast<int>(results.pictures), results.movies,
                                           results.pedestal_radius));
        result_.cells.push_back(std::move(cell));
    }

    static std::string words(const Cell& cell) {
        std::vector<std::string> parts;
        for (const CellValue& each : cell.values) parts.push_back(each.key + " = " + each.text);
        return join(parts);
    }

    /// The pattern with {key}, {list}, {sample} and {cell} filled in.
    std::string filled(const Cell& cell, const std::string& entry_name,
                       const std::string& sample_name) const {
        std::string name;
        const std::string& pattern = sweep_.cell_name;
        for (std::size_t at = 0; at < pattern.size();) {
            const std::size_t open = std::min(pattern.find('{', at), pattern.size());
            name += pattern.substr(at, open - at);
            if (open == pattern.size()) break;
            const std::size_t close = pattern.find('}', open);
            if (close == pattern.npos)
                refuse_scene(sweep_.path.string() + ": cell_name: has a { without its }");
            const std::string what = pattern.substr(open + 1, close - open - 1);
            const auto found = std::find_if(cell.values.begin(), cell.values.end(),
                                            [&](const CellValue& each) { return each.key == what; });
            if (found != cell.values.end())
                name += short_text(found->text, false);
            else if (what == "list" && !sweep_.list.empty())
                name += entry_name;
            else if (what == "sample" && sweep_.samples > 0)
                name += sample_name;
            else if (what == "cell")
                name += fmt::format("{:04d}", result_.cells.size());
            else
                refuse_scene(fmt::format("{}: cell_name: has {{{}}}; known: {{cell}}{}{}, {{{}}}",
                                         sweep_.path.string(), what, sweep_.list.empty() ? "" : ", {list}",
                                         sweep_.samples > 0 ? ", {sample}" : "", join(result_.keys, "}, {")));
            at = close + 1;
        }
        return as_name(name);
    }

    const SweepFile& sweep_;
    SweepCells result_;
    std::vector<bool> in_full_;  ///< of the grid's keys: short texts would be the same
    std::map<std::string, std::size_t> places_;
};

}  // namespace

SweepCells cells_of(const SweepFile& sweep) {
    return CellMaker(sweep).make();
}

SceneFile load_cell(const SweepFile& sweep, const Cell& cell) {
    return load_scene(sweep.scene, cell.overrides);
}

}  // namespace cloth::pipeline
