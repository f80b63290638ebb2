#pragma once
// Failures that end the program with their own exit code.

#include <stdexcept>
#include <string>

namespace cloth::pipeline {

enum class ExitCode {
    good = 0,
    other = 1,
    usage = 2,
    invalid_scene = 3,
    not_converged = 4,
    start_overlap = 5,
    golden_mismatch = 6,
    encoder = 7,
    broken_promise = 8,
    interrupted = 130,
};

/// One clear line for the user, and the exit code that goes with it.
class Error : public std::runtime_error {
  public:
    Error(ExitCode exit_code, const std::string& line) : std::runtime_error(line), code(exit_code) {}
    ExitCode code;
};

}  // namespace cloth::pipeline
