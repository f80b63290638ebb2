#pragma once
// The program as a user meets it: run in a folder of its own, its exit code, its two outputs, its files.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace cloth::testing {

struct Outcome {
    int code = -1;
    std::string out, err;
};

/// A working folder with a scene, and the program run in it.
class Workplace {
  public:
    Workplace();

    /// `setting` comes before the program on the shell's line: environment, limits.
    Outcome run(const std::string& arguments, const std::string& setting = "") const;
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    const std::filesystem::path& path() const { return folder_.path(); }
    /// All below a folder, sorted.
    std::vector<std::string> files(const std::string& below = "") const;

  private:
    TemporaryFolder folder_, logs_;
};

/// One line, on standard error, that begins with the program's name.
void check_refusal(const Outcome& outcome, int code, const std::vector<std::string>& parts);

nlohmann::json report_of(const Workplace& place, const std::string& out);
/// Of the states, frame by frame.
std::vector<std::string> hashes(const nlohmann::json& report);

inline const std::string base = "--scene sheet.toml --out o --quiet ";

}  // namespace cloth::testing
