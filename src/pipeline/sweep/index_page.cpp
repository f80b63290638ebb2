#include "pipeline/sweep/index_page.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/text.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/sweep/measures.h"
#include "pipeline/sweep/page.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json();
}

Json columns_json(const SweepResults& results) {
    Json columns = Json::array();
    for (const ResultColumn& column : results.columns) {
        std::string meaning;
        for (const Measure& measure : measures())
            if (column.measure && column.name == measure.name) meaning = measure.meaning;
        columns.push_back({{"name", column.name},
                           {"unit", column.unit},
                           {"measure", column.measure},
                           {"numeric", column.numeric},
                           {"meaning", meaning}});
    }
    return columns;
}

/// Of a file in the sweep's folder, relative to it; empty where it is not there.
std::string link(const SweepFolder& folder, const fs::path& file) {
    std::error_code missing;
    return fs::exists(file, missing) ? file.lexically_relative(folder.root()).generic_string()
                                     : std::string();
}

Json rows_json(const SweepResults& results, const SweepFolder& folder) {
    Json rows = Json::array();
    for (std::size_t r = 0; r < results.rows.size(); ++r) {
        const ResultRow& row = results.rows[r];
        const fs::path cell = folder.cell(row.cell->name);
        Json values = Json::array();
        for (const ResultColumn& column : results.columns)
            values.push_back(column.numeric ? number(column.numbers[r]) : Json(column.texts[r]));
        std::string report = link(folder, cell / "report.html");
        if (report.empty()) report = link(folder, RunFolder::look(cell).report());
        const bool has_picture = row.record && !row.record->picture.empty();
        rows.push_back({{"cell", row.cell->name},
                        {"status", row.status()},
                        {"values", std::move(values)},
                        {"picture", has_picture ? link(folder, cell / row.record->picture) : ""},
                        {"report", row.record ? report : ""},
                        {"log", row.record ? link(folder, folder.log(row.cell->name)) : ""},
                        {"frames", row.record ? row.record->frames : 0},
                        {"last_frame", row.record ? row.record->last_frame : -1},
                        {"reason", row.record ? row.record->reason : ""}});
    }
    return rows;
}

void fill(std::string& page, const std::string& place, const std::string& text) {
    const std::size_t at = page.find(place);
    if (at != page.npos) page.replace(at, place.size(), text);
}

}  // namespace

std::string index_page(const SweepResults& results, const SweepFolder& folder) {
    const SweepFile& sweep = *results.sweep;
    const Json data = {{"columns", columns_json(results)}, {"rows", rows_json(results, folder)}};
    std::string json = data.dump(-1, ' ', false, Json::error_handler_t::replace);
    // So that no text in it ends the script.
    for (std::size_t at = 0; (at = json.find("</", at)) != json.npos; at += 3) json.insert(at + 1, "\\");

    std::string page = sweep_page::index_html;
    fill(page, "@mark@", std::string(own_mark));
    for (int i = 0; i < 2; ++i) fill(page, "@title@", escaped(sweep.name));
    fill(page, "@description@", escaped(sweep.description));
    fill(page, "@scene@", escaped(fs::path(sweep.scene).stem().string()));
    fill(page, "@movie@",
         link(folder, folder.sheet()).empty()
             ? ""
             : "<video src=\"sheet.mp4\" controls loop muted autoplay></video>");
    fill(page, "@style@", sweep_page::style_css);
    fill(page, "@script@", sweep_page::script_js);
    fill(page, "@data@", json);
    return page;
}

void write_index_page(const SweepResults& results, const SweepFolder& folder) {
    write_file(folder.page(), index_page(results, folder));
}

}  // namespace cloth::pipeline
