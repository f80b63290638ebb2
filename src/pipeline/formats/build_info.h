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

/// Fingerprints of the source text that decides states, and of all source text: what was made by a program of
/// another text is not taken for its own.
std::string physics_sources();
std::string all_sources();

}  // namespace cloth::pipeline
