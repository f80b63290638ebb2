#pragma once
// The folder of a sweep's results: DIR/sweep.toml, the sweep as it was asked for last; DIR/sweep.json, whose
// folder it is; DIR/cells.jsonl, a line for each cell that has come to its end; DIR/cells/NAME, each a run;
// DIR/logs/NAME.log; DIR/results.csv, results.npz, index.html, sheet.mp4.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/whole_file.h"
#include "pipeline/formats/folder_lock.h"
#include "pipeline/sweep/cells.h"

namespace cloth::pipeline {

/// How a cell ended. `broken`: all is made, but a limit of the scene's [expect] does not hold.
enum class CellStatus { done, broken, failed };

/// One line of cells.jsonl.
struct CellRecord {
    std::string key;  ///< Cell::key of what was run
    CellStatus status = CellStatus::done;
    std::string reason;            ///< why it is not done; one line
    std::int64_t frames = 0;       ///< asked for
    std::int64_t last_frame = -1;  ///< the last good one; -1: none
    double wall = 0;               ///< that the run took [s]
    std::vector<double> measures;  ///< one per measures(); NaN where there is none; empty: failed
    std::string picture;           ///< of the last good frame, relative to the cell; empty: none
};
using CellRecords = std::map<std::string, CellRecord>;  ///< by the cells' names

const char* word(CellStatus status);

/// A record as a line of cells.jsonl, and back. record_of() throws std::exception where it is none.
std::string line_of(const std::string& cell, const CellRecord& record);
std::pair<std::string, CellRecord> record_of(const std::string& line);

class SweepFolder {
  public:
    /// For writing, and held while any copy lives. Throws Error(usage) where it holds the results of another
    /// sweep, a run, or what is the user's; Error(other) where it cannot be written or is held by another.
    static SweepFolder create(const std::filesystem::path& folder, const SweepFile& sweep);
    /// For reading. Throws Error(usage) as create() does; nothing needs to be there.
    static SweepFolder look(const std::filesystem::path& folder, const SweepFile& sweep);

    const std::filesystem::path& root() const { return root_; }
    std::filesystem::path cells() const { return root_ / "cells"; }
    std::filesystem::path cell(const std::string& name) const { return root_ / "cells" / name; }
    std::filesystem::path log(const std::string& name) const { return root_ / "logs" / (name + ".log"); }
    std::filesystem::path csv() const { return root_ / "results.csv"; }
    std::filesystem::path npz() const { return root_ / "results.npz"; }
    std::filesystem::path page() const { return root_ / "index.html"; }
    std::filesystem::path sheet() const { return root_ / "sheet.mp4"; }

    /// The last line of each cell; a line that is cut or makes no sense tells nothing.
    CellRecords read_records() const;
    void add_record(const std::string& cell, const CellRecord& record) const;

    /// What the kept movie of all cells was made of; empty: nobody knows.
    std::string read_sheet_key() const;
    void write_sheet_key(const std::string& key) const;

  private:
    explicit SweepFolder(std::filesystem::path root) : root_(std::move(root)) {}
    std::filesystem::path root_;
    std::string sweep_;
    std::shared_ptr<const FolderLock> lock_;
    std::shared_ptr<LineFile> ledger_;
};

}  // namespace cloth::pipeline
