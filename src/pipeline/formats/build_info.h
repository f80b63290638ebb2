#pragma once
// What this program was built from and with.

#include <string>

namespace cloth::pipeline {

/// "0.1.0"
std::string program_version();

/// "g++ 12.2.0"
std::string compiler();

/// States computed by two programs of the same fingerprint on one machine are the same bits: compiler, flags,
/// Eigen and the state's format.
std::string build_fingerprint();

}  // namespace cloth::pipeline
