#pragma once
// What the finished files of a run were made from: ledger.jsonl in its folder, a line for each state, picture
// and movie, added when the file has its name. The last line about a file counts. A file without a line, or
// whose bytes are not those of its line, is not believed.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "base/whole_file.h"
#include "pipeline/run/report.h"

namespace cloth::pipeline {

/// What a state was made from: `key` stands for everything that acts up to it (fingerprints.h).
struct StateEntry {
    std::string key, file;  ///< `file`: fingerprint of its bytes
    FrameRecord record;
};
struct PictureEntry {
    std::string key, file, renderer;
    double draw = 0, png = 0;  ///< [s]
};
struct MovieEntry {
    std::string key, file, encoder;
};

struct LedgerEntries {
    std::map<std::int64_t, StateEntry> states;      ///< by frame
    std::map<std::int64_t, PictureEntry> pictures;  ///< by frame
    std::map<std::string, MovieEntry> movies;       ///< by file name
};

/// What the ledger tells; a line that is cut or makes no sense tells nothing.
LedgerEntries read_ledger(const std::filesystem::path& path);

/// Several threads may write.
class Ledger {
  public:
    /// Begins anew with `entries`.
    /// `sync`: of the lines of states.
    Ledger(const std::filesystem::path& path, const LedgerEntries& entries, Sync sync = Sync::yes);
    void add_state(std::int64_t frame, const StateEntry& entry);
    void add_picture(std::int64_t frame, const PictureEntry& entry);
    void add_movie(const std::string& name, const MovieEntry& entry);

  private:
    void add(const std::string& line, Sync sync);
    std::mutex mutex_;
    std::unique_ptr<LineFile> file_;
    Sync sync_;
};

}  // namespace cloth::pipeline
