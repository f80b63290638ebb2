#include "pipeline/sweep/results.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/npy.h"
#include "pipeline/formats/raw_bytes.h"
#include "pipeline/sweep/measures.h"

namespace cloth::pipeline {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Without the quotes of a text.
std::string plain(const std::string& toml) {
    if (toml.empty() || toml[0] != '"') return toml;
    return toml::parse("v = " + toml)["v"].value_or(toml);
}

ResultColumn key_column(const SweepCells& cells, const std::string& key) {
    ResultColumn column{key, "", false, {}, {}, true};
    for (const Cell& cell : cells.cells) {
        const auto found = std::find_if(cell.values.begin(), cell.values.end(),
                                        [&](const CellValue& value) { return value.key == key; });
        const bool has = found != cell.values.end();
        column.numbers.push_back(has ? found->number : none);
        column.texts.push_back(has ? plain(found->text) : "");
        if (has && std::isnan(found->number)) column.numeric = false;
    }
    return column;
}

void add_number(ResultColumn& column, double number) {
    column.numbers.push_back(number);
    column.texts.push_back(std::isnan(number) ? "" : fmt::format("{}", number));
}

std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == text.npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + '"';
}

/// Texts as NumPy's fixed-length bytes of UTF-8.
void write_texts(NpzWriter& zip, const std::string& name, const std::vector<std::string>& texts) {
    std::size_t longest = 1;
    for (const std::string& text : texts) longest = std::max(longest, text.size());
    std::string bytes;
    for (std::string text : texts) {
        text.resize(longest, '\0');
        bytes += text;
    }
    zip.array(name, fmt::format("|S{}", longest), {static_cast<std::int64_t>(texts.size())}, bytes);
}

template <class T>
void write_numbers(NpzWriter& zip, const std::string& name, const char* type, const std::vector<T>& numbers) {
    std::string bytes;
    for (const T number : numbers) put(bytes, number);
    zip.array(name, type, {static_cast<std::int64_t>(numbers.size())}, bytes);
}

const ResultColumn& column_named(const SweepResults& results, const std::string& name) {
    std::vector<std::string> known;
    for (const ResultColumn& column : results.columns) {
        known.push_back(column.name);
        if (column.name != name) continue;
        if (!column.numeric)
            throw Error(ExitCode::usage, fmt::format("--plot: {} is no number in every cell", name));
        return column;
    }
    const std::string near = nearest_word(name, known);
    throw Error(ExitCode::usage, fmt::format("--plot: the results have no {}; {}known: {}", name,
                                             near.empty() ? "" : "did you mean " + near + "? ", join(known)));
}

std::string axis_label(const ResultColumn& column) {
    std::string text = column.name;
    if (column.measure) std::replace(text.begin(), text.end(), '_', ' ');
    return text + (column.unit.empty() ? "" : " [" + column.unit + "]");
}

bool spans_decades(const ResultColumn& column) {
    double low = HUGE_VAL, high = 0;
    for (const double number : column.numbers) {
        if (std::isnan(number)) continue;
        low = std::min(low, number);
        high = std::max(high, number);
    }
    return low > 0 && high > 50 * low;
}

}  // namespace

SweepResults results_of(const SweepFile& sweep, SweepCells cells, const CellRecords& records) {
    SweepResults results;
    results.sweep = &sweep;
    results.cells = std::move(cells);
    results.records = records;
    for (const Cell& cell : results.cells.cells) {
        const auto found = results.records.find(cell.name);
        const bool is_its = found != results.records.end() && found->second.key == cell.key;
        results.rows.push_back({&cell, is_its ? &found->second : nullptr});
    }
    for (const std::string& key : results.cells.keys)
        results.columns.push_back(key_column(results.cells, key));
    for (std::size_t c = 0; c < sweep.columns.size(); ++c) {
        ResultColumn column{sweep.columns[c].first, "", false, {}, {}, true};
        for (const Cell& cell : results.cells.cells) add_number(column, cell.columns.at(c));
        results.columns.push_back(std::move(column));
    }
    for (const std::string& name : sweep.results.measures) {
        const auto& all = measures();
        const auto m = static_cast<std::size_t>(
            std::find_if(all.begin(), all.end(), [&](const Measure& each) { return each.name == name; }) -
            all.begin());
        ResultColumn column{name, all.at(m).unit, true, {}, {}, true};
        for (const ResultRow& row : results.rows)
            add_number(column,
                       row.record && m < row.record->measures.size() ? row.record->measures[m] : none);
        results.columns.push_back(std::move(column));
    }
    return results;
}

std::string results_csv(const SweepResults& results) {
    std::string text = "cell,status,sample";
    for (const ResultColumn& column : results.columns) text += "," + csv_field(column.name);
    text += ",frames,last_frame,reason\r\n";
    for (std::size_t r = 0; r < results.rows.size(); ++r) {
        const ResultRow& row = results.rows[r];
        text += csv_field(row.cell->name) + "," + row.status() + ",";
        if (row.cell->sample >= 0) text += std::to_string(row.cell->sample);
        for (const ResultColumn& column : results.columns) {
            const bool missing = column.texts[r].empty() && column.measure;
            text += "," + csv_field(missing ? "nan" : column.texts[r]);
        }
        text += row.record ? fmt::format(",{},{},{}", row.record->frames, row.record->last_frame,
                                         csv_field(row.record->reason))
                           : ",,,";
        text += "\r\n";
    }
    return text;
}

void write_results_npz(const SweepResults& results, const std::filesystem::path& file) {
    GrowingFile whole(file);
    NpzWriter zip(whole.part(), file);
    std::vector<std::string> names, status, columns, units;
    std::vector<std::int64_t> samples;
    for (const ResultRow& row : results.rows) {
        names.push_back(row.cell->name);
        status.push_back(row.status());
        samples.push_back(row.cell->sample);
    }
    write_texts(zip, "cells", names);
    write_texts(zip, "status", status);
    write_numbers(zip, "sample", "<i8", samples);
    for (const ResultColumn& column : results.columns) {
        columns.push_back(column.name);
        units.push_back(column.unit);
        if (column.numeric)
            write_numbers(zip, column.name, "<f8", column.numbers);
        else
            write_texts(zip, column.name, column.texts);
    }
    write_texts(zip, "columns", columns);
    write_texts(zip, "units", units);
    zip.close();
    whole.finish();
}

Plot plot_of(const SweepResults& results, const std::string& x, const std::string& y) {
    const ResultColumn &along = column_named(results, x), &up = column_named(results, y);
    const ResultColumn* series = nullptr;
    for (const ResultColumn& column : results.columns) {
        if (column.numeric || series) continue;
        const std::set<std::string> words(column.texts.begin(), column.texts.end());
        if (words.size() > 1 && words.size() <= 6) series = &column;
    }
    Plot plot{"",
              results.sweep->description.empty() ? results.sweep->name : results.sweep->description,
              axis_label(along),
              axis_label(up),
              spans_decades(along),
              spans_decades(up),
              {}};
    for (std::size_t r = 0; r < results.rows.size(); ++r) {
        const ResultRow& row = results.rows[r];
        if (!row.record || row.record->status == CellStatus::failed) continue;
        const std::string label = series ? series->texts[r] : fmt::format("{} cells", results.rows.size());
        auto curve = std::find_if(plot.curves.begin(), plot.curves.end(),
                                  [&](const cloth::Curve& each) { return each.label == label; });
        if (curve == plot.curves.end())
            curve = plot.curves.insert(plot.curves.end(), cloth::Curve{label, {}, true});
        curve->points.push_back({along.numbers[r], up.numbers[r]});
    }
    return plot;
}

}  // namespace cloth::pipeline
