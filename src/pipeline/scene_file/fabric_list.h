#pragma once
// The table of fabrics as text.

#include <string>

namespace cloth::pipeline {

/// One line per fabric with its values, below each other with units above.
std::string fabric_table();

/// One row of Markdown per fabric: what it is, weight, bending length.
std::string fabric_rows();

/// Every number of every fabric, or of the one named, with its source. Throws Error(usage) for an unknown
/// name.
std::string fabric_sources(const std::string& name = "");

/// What to say of a fabric that the table (sim/scene/fabrics.h) does not have: the nearest name and all known
/// ones.
std::string unknown_fabric(const std::string& name);

}  // namespace cloth::pipeline
