#pragma once
// What programs read that drive this one: JSON on standard output.

#include <nlohmann/json_fwd.hpp>

namespace cloth::cli {

/// One object on one line, at once.
void print_json_line(const nlohmann::ordered_json& json);
/// Indented, for a result that is printed whole.
void print_json(const nlohmann::ordered_json& json);

}  // namespace cloth::cli
