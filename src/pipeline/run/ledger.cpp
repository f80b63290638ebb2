#include "pipeline/run/ledger.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/scene_file/picture_schema.h"

namespace cloth::pipeline {

namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string line_of(std::int64_t frame, const StateEntry& e) {
    return line_of(
        Json{{"state", frame}, {"key", e.key}, {"file", e.file}, {"report", frame_json(e.record)}});
}

std::string line_of(std::int64_t frame, const PictureEntry& e) {
    return line_of(Json{{"picture", frame},
                        {"key", e.key},
                        {"file", e.file},
                        {"renderer", e.renderer},
                        {"seconds", {e.draw, e.png}}});
}

std::string line_of(const std::string& name, const MovieEntry& e) {
    return line_of(Json{{"movie", name}, {"key", e.key}, {"file", e.file}, {"encoder", e.encoder}});
}

std::int64_t frame_of(const Json& json) {
    const auto frame = json.get<std::int64_t>();
    if (frame < 0 || frame >= most_frames) throw std::out_of_range("frame");
    return frame;
}

/// Throws where the line makes no sense.
void take(LedgerEntries& entries, const Json& json) {
    if (json.contains("state")) {
        const std::int64_t frame = frame_of(json.at("state"));
        StateEntry e{json.at("key"), json.at("file"), frame_record(json.at("report"))};
        if (e.record.report.frame != frame) throw std::out_of_range("frame");
        entries.states[frame] = std::move(e);
    } else if (json.contains("picture")) {
        entries.pictures[frame_of(json.at("picture"))] = {json.at("key"), json.at("file"),
                                                          json.at("renderer"), json.at("seconds").at(0),
                                                          json.at("seconds").at(1)};
    } else {
        entries.movies[json.at("movie")] = {json.at("key"), json.at("file"), json.at("encoder")};
    }
}

}  // namespace

LedgerEntries read_ledger(const std::filesystem::path& path) {
    LedgerEntries entries;
    std::string text;
    try {
        text = read_file(path);
    } catch (const Error&) {
        return entries;
    }
    std::string_view rest = text;
    while (!rest.empty()) {
        const std::size_t end = rest.find('\n');
        if (end == rest.npos) break;
        try {
            take(entries, Json::parse(rest.substr(0, end)));
        } catch (const std::exception&) {
            // Cut, or not ours: what it told of is made again.
        }
        rest.remove_prefix(end + 1);
    }
    return entries;
}

Ledger::Ledger(const std::filesystem::path& path, const LedgerEntries& entries, Sync sync) : sync_(sync) {
    std::string text;
    for (const auto& [frame, entry] : entries.states) text += line_of(frame, entry) + '\n';
    for (const auto& [frame, entry] : entries.pictures) text += line_of(frame, entry) + '\n';
    for (const auto& [name, entry] : entries.movies) text += line_of(name, entry) + '\n';
    write_if_changed(path, text);
    file_ = std::make_unique<LineFile>(path);
}

void Ledger::add(const std::string& line, Sync sync) {
    const std::lock_guard lock(mutex_);
    try {
        file_->add(line, sync);
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::other, e.what());
    }
}

void Ledger::add_state(std::int64_t frame, const StateEntry& entry) {
    add(line_of(frame, entry), sync_);
}
void Ledger::add_picture(std::int64_t frame, const PictureEntry& entry) {
    add(line_of(frame, entry), Sync::no);  // drawn again as quickly as found missing
}
void Ledger::add_movie(const std::string& name, const MovieEntry& entry) {
    add(line_of(name, entry), Sync::no);
}

}  // namespace cloth::pipeline
