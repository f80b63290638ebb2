#pragma once
// Words and numbers of mesh files that are text.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// A word as a message quotes it, cut short where it is long.
std::string quoted(std::string_view word);

/// The words of a line go into `words`, in place of what it held.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& words);

/// The whole word as a finite number. Throws Error(invalid_scene).
double parse_double(std::string_view word, const FilePlace& place);
/// The whole word as a whole number. Throws Error(invalid_scene).
std::int64_t parse_integer(std::string_view word, const FilePlace& place);

}  // namespace cloth::pipeline
