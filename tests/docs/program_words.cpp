#include "docs/program_words.h"

#include <cctype>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "pipeline/scene_file/scene_file.h"
#include "sim/scene/fabrics.h"
#include "validation/validation.h"

namespace cloth::testing {
namespace fs = std::filesystem;
namespace {

std::string output_of(const std::string& command) {
    FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) throw std::runtime_error("cannot run: " + command);
    std::string text;
    for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    if (pclose(pipe) != 0) throw std::runtime_error("failed: " + command);
    return text;
}

/// The first word of each line that is indented by two spaces.
std::set<std::string> first_words(const std::string& text) {
    std::set<std::string> words;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.size() > 2 && line.starts_with("  ") && line[2] != ' ')
            words.insert(line.substr(2, line.find_first_of(" ,", 2) - 2));
    return words;
}

Verb verb_of(const std::string& help) {
    Verb verb{help, {}};
    for (std::size_t at = help.find("--"); at != std::string::npos; at = help.find("--", at + 2)) {
        std::size_t end = at + 2;
        while (end < help.size() && (std::isalnum(static_cast<unsigned char>(help[end])) || help[end] == '-'))
            ++end;
        verb.flags.insert(help.substr(at, end - at));
    }
    return verb;
}

}  // namespace

std::string read_text(const fs::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    return {std::istreambuf_iterator<char>(in), {}};
}

std::set<std::string> words_of(const std::string& text) {
    std::set<std::string> words;
    std::string word;
    for (std::size_t i = 0; i <= text.size(); ++i) {
        const char c = i < text.size() ? text[i] : ' ';
        const bool letter = std::isalpha(static_cast<unsigned char>(c)) || c == '_';
        if (letter || (!word.empty() && std::isdigit(static_cast<unsigned char>(c)))) {
            word += c;
        } else if (!word.empty()) {
            words.insert(std::move(word));
            word.clear();
        }
    }
    return words;
}

ProgramWords ask_program(const std::string& binary, const fs::path& root) {
    ProgramWords known;
    const std::string program = "'" + binary + "'", help = output_of(program + " --help");
    const std::size_t verbs = help.find("Subcommands:");
    known.verbs[""] = verb_of(help.substr(0, verbs));
    for (const std::string& name : first_words(help.substr(verbs)))
        known.verbs[name] = verb_of(output_of(program + " " + name + " --help"));

    for (const auto& scene : pipeline::list_scenes()) known.scenes.insert(scene[0]);
    for (const NamedFabric& named : named_fabrics()) known.fabrics.insert(named.fabric.name);
    for (const validation::Check& check : validation::checks()) known.checks.insert(check.name);
    known.keys = first_words(pipeline::key_reference());
    known.keys.insert("fabric");  // a name or a table of its own

    const auto presets = nlohmann::json::parse(read_text(root / "CMakePresets.json"));
    for (const auto& preset : presets["configurePresets"]) known.presets.insert(preset["name"]);
    known.sources = read_text(root / "CMakeLists.txt") + read_text(root / "CMakePresets.json");
    known.targets = words_of(known.sources);
    known.demo = read_text(root / "demo");
    for (const char* folder : {"src", "apps", "bench", "scripts"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            if (entry.is_regular_file()) known.sources += read_text(entry.path());

    known.identifiers = words_of(known.sources);
    for (const auto* names : {&known.scenes, &known.fabrics, &known.checks, &known.keys})
        known.identifiers.insert(names->begin(), names->end());
    for (const auto& [name, verb] : known.verbs) known.identifiers.merge(words_of(name + " " + verb.help));
    return known;
}

}  // namespace cloth::testing
