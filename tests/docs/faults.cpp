#include "docs/faults.h"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

#include "docs/markdown.h"
#include "pipeline/scene_file/scene_file.h"
#include "pipeline/sweep/sweep_file.h"

namespace cloth::testing {
namespace fs = std::filesystem;
namespace {

/// NAME, A:B, 1, or state_NNNNNN.
bool placeholder(const std::string& word) {
    return word.ends_with("_NNNNNN") ||
           std::none_of(word.begin(), word.end(), [](unsigned char c) { return std::islower(c); });
}

/// Words between spaces, without the brackets that mark what may be left out.
std::vector<std::string> arguments_of(std::string command) {
    // What the command is for stands behind three spaces.
    command = command.substr(0, command.find("   "));
    std::istringstream in(command);
    std::vector<std::string> list;
    for (std::string word; in >> word;) {
        if (word.ends_with("...")) word.resize(word.size() - 3);
        if (word.starts_with('[')) word.erase(0, 1);
        if (word.ends_with(']') && word.find('[') == std::string::npos) word.pop_back();
        if (!word.empty() && word != "…") list.push_back(word);
    }
    return list;
}

class Checker {
  public:
    Checker(const fs::path& file, const fs::path& root, const ProgramWords& known)
        : file_(file), root_(root), known_(known) {}

    std::vector<std::string> check(const Page& page) {
        for (const Link& link : page.links) check_link(link, page);
        for (const Code& block : page.blocks) {
            if (block.language == "toml") check_toml(block);
            if (block.language.empty() || block.language == "sh") check_commands(block);
        }
        for (const Code& span : page.spans) check_span(span);
        std::sort(faults_.begin(), faults_.end());
        std::vector<std::string> lines;
        for (const auto& [line, what] : faults_)
            lines.push_back(file_.generic_string() + ":" + std::to_string(line) + ": " + what);
        return lines;
    }

  private:
    void fault(int line, const std::string& what) { faults_.emplace_back(line, what); }

    void check_link(const Link& link, const Page& page) {
        if (link.target.starts_with("http")) return;
        const std::size_t hash = std::min(link.target.find('#'), link.target.size());
        const std::string path = link.target.substr(0, hash), anchor = link.target.substr(hash);
        const fs::path target = root_ / file_.parent_path() / path;
        if (!path.empty() && !fs::exists(target)) return fault(link.line, "no file " + path);
        if (anchor.empty()) return;
        const auto anchors = path.empty() ? page.anchors : read_page(read_text(target)).anchors;
        if (!anchors.contains(anchor.substr(1))) fault(link.line, "no heading " + link.target);
    }

    void check_sweep(const Code& block) {
        try {
            pipeline::parse_sweep(block.text, "example.toml");
        } catch (const std::exception& e) {
            fault(block.line, std::string("does not load: ") + e.what());
        }
    }

    void check_toml(const Code& block) {
        std::string text = block.text;
        if (text.find("\nscene = ") != std::string::npos) return check_sweep(block);
        if (!text.starts_with("version") && text.find("\nversion") == std::string::npos)
            text = "version = 1\n" + text;
        if (text.find("[[cloth]]") == std::string::npos) text += "\n[[cloth]]\n";
        try {
            pipeline::parse_scene(text, "example", root_);
        } catch (const std::exception& e) {
            fault(block.line, std::string("does not load: ") + e.what());
        }
    }

    void check_commands(const Code& block) {
        std::istringstream lines(block.text);
        std::string verb;  // of the command that a line beginning with [--flag goes on with
        int number = block.line;
        for (std::string line; std::getline(lines, line); ++number) {
            line.erase(0, line.find_first_not_of(' '));
            if (line.starts_with("[--"))
                check_arguments(verb, arguments_of(line), number);
            else
                verb = check_command(line, number);
        }
    }

    /// A line of a shell; the verb, where it is the program's.
    std::string check_command(const std::string& line, int number) {
        const std::string program = "render_cloth ";
        if (const std::size_t at = line.find(program); at != std::string::npos)
            return check_program(arguments_of(line.substr(at + program.size())), number);
        const auto words = arguments_of(line);
        if (words.empty()) return "";
        if (words[0].starts_with("./")) check_file(words[0], number);
        const bool own = words.size() == 2 && known_.demo.find('"' + words[1] + '"') != std::string::npos;
        if (words[0] == "./demo" && !own) check_arguments("", {words.begin() + 1, words.end()}, number);
        for (std::size_t i = 0; i + 1 < words.size(); ++i) {
            if (words[i] == "--preset" && !known_.presets.contains(words[i + 1]))
                fault(number, "no preset " + words[i + 1]);
            if (words[i] == "--target" && !known_.targets.contains(words[i + 1]))
                fault(number, "no target " + words[i + 1]);
        }
        if (words[0].starts_with("--")) check_flags(words, number);
        return "";
    }

    std::string check_program(const std::vector<std::string>& words, int number) {
        if (words.empty() || words[0].starts_with("--")) {
            check_arguments("", words, number);
            return "";
        }
        if (!known_.verbs.contains(words[0])) {
            fault(number, "no verb " + words[0]);
            return "";
        }
        check_arguments(words[0], {words.begin() + 1, words.end()}, number);
        return words[0];
    }

    /// What follows a verb.
    void check_arguments(const std::string& verb, const std::vector<std::string>& words, int number) {
        const Verb& own = known_.verbs.at(verb);
        const auto must_know = [&](const char* what, const std::set<std::string>& names,
                                   const std::string& name) {
            if (!placeholder(name) && !names.contains(name))
                fault(number, std::string("no ") + what + " " + name);
        };
        std::string flag, previous;
        for (const std::string& word : words) {
            if (word.starts_with("--")) {
                flag = word.substr(0, word.find('='));
                if (!own.flags.contains(flag))
                    fault(number, "no flag " + flag + (verb.empty() ? "" : " of " + verb));
            } else if (flag == "--set") {
                check_setting(word, number);
            } else if (flag == "--scene") {
                if (!word.ends_with(".toml")) must_know("scene", known_.scenes, word);
            } else if (flag == "--fabric") {
                must_know("fabric", known_.fabrics, word);
            } else if (flag.empty() && (verb == "compare" || verb == "bless")) {
                must_know("scene", known_.scenes, word);
            } else if (flag.empty() && verb == "validate") {
                must_know("check", known_.checks, word);
            } else if (flag.empty() && verb == "list" && previous == "fabrics") {
                must_know("fabric", known_.fabrics, word);
            } else if (flag.empty() && verb == "list") {
                must_know("list of", words_of(own.help), word);
            }
            previous = word;
        }
    }

    void check_flags(const std::vector<std::string>& words, int number) {
        for (const std::string& word : words) {
            if (!word.starts_with("--")) continue;
            const std::string flag = word.substr(0, word.find('='));
            const bool of_a_verb =
                std::any_of(known_.verbs.begin(), known_.verbs.end(),
                            [&](const auto& verb) { return verb.second.flags.contains(flag); });
            if (!of_a_verb && known_.sources.find('"' + flag + '"') == std::string::npos)
                fault(number, "no flag " + flag);
        }
        for (std::size_t i = 0; i + 1 < words.size(); ++i)
            if (words[i] == "--set") check_setting(words[i + 1], number);
    }

    /// KEY=VALUE, as the program takes it.
    void check_setting(const std::string& setting, int number) {
        if (setting == "KEY=VALUE") return;
        try {
            pipeline::load_scene("drape_sphere", {setting});
        } catch (const std::exception& e) {
            fault(number, e.what());
        }
    }

    void check_file(const std::string& path, int number) {
        for (const fs::path& folder : {root_, root_ / "src", root_ / file_.parent_path()})
            if (fs::exists(folder / path) || fs::exists(folder / (path + ".cpp"))) return;
        fault(number, "no file " + path);
    }

    void check_span(const Code& span) {
        static const std::regex assignment(R"(([a-z_.\[\]0-9]+)\s*=\s*(.*))"),
            path(R"(\.?[\w./-]*(/[\w.-]*|\.(h|cpp|md|toml|json|cmake|sh|yml|glsl)))"),
            name(R"([A-Za-z_]\w*((\.|::)[A-Za-z_]\w*)*(\(\))?)"), text_value(R"re("([^"]*)")re");
        const std::string& text = span.text;
        std::smatch parts;
        const auto words = arguments_of(text);
        if (words.empty()) return;
        if (text.starts_with("render_cloth ") || text.starts_with("./") || text.starts_with("cmake ") ||
            text.find(" --preset ") != std::string::npos) {
            check_command(text, span.line);
        } else if (words.size() > 1 && known_.verbs.contains(words[0])) {
            check_program(words, span.line);
        } else if (words[0].starts_with("--")) {
            check_flags(words, span.line);
        } else if (std::regex_match(text, parts, assignment)) {
            const std::string key = parts[1], value = parts[2];
            const std::string last = key.substr(key.find_last_of('.') + 1);
            if (!known_.keys.contains(last.substr(0, last.find('[')))) fault(span.line, "no key " + key);
            for (std::sregex_iterator each(value.begin(), value.end(), text_value), end; each != end; ++each)
                check_words((*each)[1], span.line);
        } else if (std::regex_match(text, path)) {
            // What a run leaves behind is named by the sources.
            const bool in_text = known_.sources.find('"' + text) != std::string::npos ||
                                 known_.sources.find('/' + text) != std::string::npos;
            if (!text.starts_with("out/") && !in_text) check_file(text, span.line);
        } else if (std::regex_match(text, name)) {
            check_words(text, span.line);
        }
    }

    void check_words(const std::string& text, int line) {
        for (const std::string& word : words_of(text)) {
            const auto next = known_.identifiers.lower_bound(word);
            // `seed_` stands for all names that begin so.
            const bool there = next != known_.identifiers.end() &&
                               (*next == word || (word.ends_with('_') && next->starts_with(word)));
            if (!placeholder(word) && !there)
                fault(line, "neither the program nor its sources have `" + word + "`");
        }
    }

    const fs::path &file_, &root_;
    const ProgramWords& known_;
    std::vector<std::pair<int, std::string>> faults_;
};

}  // namespace

std::vector<std::string> faults_of(const std::string& markdown, const fs::path& file, const fs::path& root,
                                   const ProgramWords& known) {
    return Checker(file, root, known).check(read_page(markdown));
}

}  // namespace cloth::testing
