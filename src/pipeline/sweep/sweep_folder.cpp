#include "pipeline/sweep/sweep_folder.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/sweep/measures.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr CellStatus all_status[] = {CellStatus::done, CellStatus::broken, CellStatus::failed};

fs::path manifest_of(const fs::path& folder) {
    return folder / "sweep.json";
}

Json read_manifest(const fs::path& folder) {
    return Json::parse(read_file(manifest_of(folder)), nullptr, false);
}

/// Throws Error(usage) where the folder is not this sweep's and not empty.
void require_sweep_folder(const fs::path& folder, const SweepFile& sweep) {
    std::error_code failure;
    const std::string place = "--out " + folder.string();
    const fs::file_status status = fs::status(folder, failure);
    if (status.type() == fs::file_type::not_found) return;
    if (!fs::is_directory(status)) throw Error(ExitCode::usage, place + ": is a file; give a folder");
    if (!fs::exists(manifest_of(folder), failure)) {
        for (const auto& entry : fs::directory_iterator(folder, failure)) {
            const std::string name = entry.path().filename().string();
            if (name == lock_name || !target_of_part(name).empty()) continue;
            throw Error(ExitCode::usage,
                        fmt::format("{}: holds {}, and no sweep; give a new or empty folder", place, name));
        }
        return;
    }
    const Json json = read_manifest(folder);
    if (!json.is_object() || !json.contains("sweep") || !json["sweep"].is_string())
        throw Error(ExitCode::usage, fmt::format("{}: sweep.json is damaged; give another folder", place));
    const std::string other = json["sweep"];
    if (other != sweep.name)
        throw Error(ExitCode::usage,
                    fmt::format("{}: holds the results of another sweep, {}; give {} a folder "
                                "of its own",
                                place, other, sweep.name));
}

}  // namespace

const char* word(CellStatus status) {
    switch (status) {
        case CellStatus::done:
            return "done";
        case CellStatus::broken:
            return "broken";
        default:
            return "failed";
    }
}

std::pair<std::string, CellRecord> record_of(const std::string& line) {
    const Json json = Json::parse(line);
    CellRecord record;
    json.at("key").get_to(record.key);
    const std::string status = json.at("status");
    for (const CellStatus each : all_status)
        if (status == word(each)) record.status = each;
    if (status != word(record.status)) throw std::invalid_argument("status");
    json.at("reason").get_to(record.reason);
    json.at("frames").get_to(record.frames);
    json.at("last_frame").get_to(record.last_frame);
    json.at("wall_s").get_to(record.wall);
    json.at("picture").get_to(record.picture);
    const Json& values = json.at("measures");
    if (!values.empty())
        for (const Measure& measure : measures()) {
            const Json& value = values.at(measure.name);
            record.measures.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                                      : value.get<double>());
        }
    return {json.at("cell").get<std::string>(), std::move(record)};
}

std::string line_of(const std::string& cell, const CellRecord& record) {
    Json values = Json::object();
    for (std::size_t m = 0; m < record.measures.size(); ++m)
        values[measures()[m].name] = std::isfinite(record.measures[m]) ? Json(record.measures[m]) : Json();
    const Json json = {{"cell", cell},
                       {"key", record.key},
                       {"status", word(record.status)},
                       {"reason", record.reason},
                       {"frames", record.frames},
                       {"last_frame", record.last_frame},
                       {"wall_s", record.wall},
                       {"picture", record.picture},
                       {"measures", values}};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

SweepFolder SweepFolder::look(const fs::path& folder, const SweepFile& sweep) {
    require_sweep_folder(folder, sweep);
    SweepFolder result(folder);
    result.sweep_ = sweep.name;
    return result;
}

SweepFolder SweepFolder::create(const fs::path& folder, const SweepFile& sweep) {
    SweepFolder result = look(folder, sweep);
    const auto make = [](const fs::path& each) {
        std::error_code failure;
        fs::create_directories(each, failure);
        if (failure)
            throw Error(ExitCode::other,
                        fmt::format("cannot make the folder {}: {}", each.string(), failure.message()));
    };
    make(folder);
    result.lock_ = std::make_shared<FolderLock>(folder);
    require_sweep_folder(folder, sweep);  // now that no other program writes there
    std::error_code missing;
    if (!fs::exists(manifest_of(folder), missing)) result.write_sheet_key("");
    make(result.cells());
    make(folder / "logs");
    write_if_changed(folder / "sweep.toml", sweep.text);
    result.ledger_ = std::make_shared<LineFile>(folder / "cells.jsonl");
    return result;
}

CellRecords SweepFolder::read_records() const {
    CellRecords records;
    std::error_code missing;
    const fs::path path = root_ / "cells.jsonl";
    if (!fs::exists(path, missing)) return records;
    std::istringstream lines(read_file(path));
    for (std::string line; std::getline(lines, line);) {
        try {
            auto [cell, record] = record_of(line);
            records.insert_or_assign(std::move(cell), std::move(record));
        } catch (const std::exception&) {
            // Cut when the program was killed.
        }
    }
    return records;
}

void SweepFolder::add_record(const std::string& cell, const CellRecord& record) const {
    ledger_->add(line_of(cell, record), Sync::no);
}

std::string SweepFolder::read_sheet_key() const {
    const Json json = read_manifest(root_);
    const auto key = json.is_object() ? json.find("sheet") : json.end();
    return key != json.end() && key->is_string() ? key->get<std::string>() : std::string();
}

void SweepFolder::write_sheet_key(const std::string& key) const {
    write_file(manifest_of(root_), Json({{"sweep", sweep_}, {"sheet", key}}).dump(1) + "\n");
}

}  // namespace cloth::pipeline
