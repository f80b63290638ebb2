#pragma once
// The words that the program answers to, asked from the program itself and its sources.

#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace cloth::testing {

struct Verb {
    std::string help;
    std::set<std::string> flags;  ///< "--out"
};

struct ProgramWords {
    std::map<std::string, Verb> verbs;  ///< "" stands for a command without a verb
    std::set<std::string> scenes, fabrics, checks, keys;
    std::set<std::string> presets, targets;  ///< of CMake
    std::set<std::string> identifiers;       ///< every word of sources, build files and the above
    std::string sources;                     ///< their text
    std::string demo;                        ///< of ./demo, which has flags of its own
};

/// `binary`: the program; `root`: the source tree.
ProgramWords ask_program(const std::string& binary, const std::filesystem::path& root);

std::string read_text(const std::filesystem::path& file);

/// The words of `text`: letters, digits and underscores, the first no digit.
std::set<std::string> words_of(const std::string& text);

}  // namespace cloth::testing
