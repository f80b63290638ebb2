#pragma once
// What a page says that is not so.

#include <filesystem>
#include <string>
#include <vector>

#include "docs/program_words.h"

namespace cloth::testing {

/// One line for each, "README.md:12: …". Refused are
/// - links to files and headings that are not there,
/// - commands with a verb, flag, scene, fabric, check, key, preset or target that is not there,
/// - TOML that does not load (a part of a scene is completed by a version and a cloth),
/// - code in the text that looks like a file, a key's assignment or a name, and is none.
/// Words in capitals (NAME, A:B) stand for a user's own. `file`: relative to `root`, the source tree.
std::vector<std::string> faults_of(const std::string& markdown, const std::filesystem::path& file,
                                   const std::filesystem::path& root, const ProgramWords& known);

}  // namespace cloth::testing
