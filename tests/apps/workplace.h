#pragma once
// The program as a user meets it: run in a folder of its own, its exit code, its two outputs, its files.

#include <sys/types.h>

#include <filesystem>
#include <functional>
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

    /// A shell script that is found for ffmpeg where PATH=$PWD/bin:$PATH is set. It knows its version.
    void stand_in_for_ffmpeg(const std::string& script) const;

  private:
    TemporaryFolder folder_, logs_;
};

/// The program at work, to be disturbed.
class Started {
  public:
    /// As Workplace::run(), but not waited for, and with what stands in for ffmpeg, if anything.
    Started(const Workplace& place, const std::string& arguments);
    Started(const Started&) = delete;
    ~Started();  ///< ends it
    void send(int signal) const;
    /// Its end; code -1 where it does not come within half a minute, or `seconds`.
    Outcome wait(double seconds = 30);
    pid_t pid() const { return pid_; }

  private:
    TemporaryFolder logs_;
    pid_t pid_ = -1;
};

/// Waits until something is so, for half a minute at most.
bool comes_true(const std::function<bool()>& condition, double seconds = 30);

/// One line, on standard error, that begins with the program's name.
void check_refusal(const Outcome& outcome, int code, const std::vector<std::string>& parts);

nlohmann::json report_of(const Workplace& place, const std::string& out);
/// Of the states, frame by frame.
std::vector<std::string> hashes(const nlohmann::json& report);

inline const std::string base = "--scene sheet.toml --out o --quiet ";

}  // namespace cloth::testing
