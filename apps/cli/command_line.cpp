#include "apps/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "base/text.h"

namespace cloth::cli {
namespace {

CLI::Option* dressed(CLI::Option* option, const Flag& flag) {
    return option->type_name(flag.value)->required(flag.required);
}

}  // namespace

void refuse(const std::string& line) {
    throw pipeline::Error(ExitCode::usage, line);
}

void Flags::yes(const std::string& name, bool& given, const std::string& help) {
    known_.push_back({{name, "", help, false}, {}});
    app_.add_flag(name, given, help);
}

void Flags::text(const Flag& flag, std::string& value) {
    known_.push_back({flag, {}});
    dressed(app_.add_option(flag.name, value, flag.help), flag);
}

void Flags::integer(const Flag& flag, int& value, int least, int greatest) {
    known_.push_back({flag, {}});
    dressed(app_.add_option(flag.name, value, flag.help), flag)->check(CLI::Range(least, greatest));
}

void Flags::number(const Flag& flag, double& value, double least, double greatest) {
    known_.push_back({flag, {}});
    dressed(app_.add_option(flag.name, value, flag.help), flag)->check(CLI::Range(least, greatest));
}

void Flags::choice(const Flag& flag, std::string& value, const std::vector<std::string>& names) {
    known_.push_back({flag, names});
    dressed(app_.add_option(flag.name, value, flag.help), flag)->check(CLI::IsMember(names));
}

void Flags::words(const Flag& flag, std::vector<std::string>& values, int count) {
    known_.push_back({flag, {}});
    dressed(app_.add_option(flag.name, values, flag.help), flag)->expected(count);
}

void Flags::repeated(const Flag& flag, std::vector<std::string>& values) {
    known_.push_back({flag, {}});
    // One word a flag, so that what follows it is not taken for another value.
    dressed(app_.add_option(flag.name, values, flag.help), flag)->allow_extra_args(false);
}

std::vector<KnownVerb> known_verbs(const std::vector<Verb>& verbs) {
    std::vector<KnownVerb> known;
    for (const Verb& verb : verbs) {
        CLI::App app;
        Flags flags(app);
        const Action unused = verb.add(flags);
        known.push_back({verb.name, verb.help, flags.known()});
    }
    return known;
}

Action parse(std::vector<std::string> words, const std::vector<Verb>& verbs) {
    CLI::App app("Simulates cloth, draws every frame, and makes a movie of it.", "render_cloth");
    app.require_subcommand(0, 1);
    app.get_formatter()->column_width(34);
    // For the help alone: below, a command line without a verb gets one.
    app.add_flag("--version")->description("As the verb version");
    Flags top(app);
    const Action unused = verbs.front().add(top);
    std::vector<std::string> names;
    std::vector<Action> actions;
    for (const Verb& verb : verbs) {
        Flags flags(*app.add_subcommand(verb.name, verb.help));
        names.push_back(verb.name);
        actions.push_back(verb.add(flags));
    }

    if (!words.empty() && words.front() == "--version") words.front() = "version";
    if (words.empty() ||
        (words.front().starts_with('-') && words.front() != "--help" && words.front() != "-h"))
        words.insert(words.begin(), verbs.front().name);
    const std::string word = words.front();
    const auto chosen = std::find(names.begin(), names.end(), word);
    if (chosen == names.end() && !word.starts_with('-')) {
        const std::string near = nearest_word(word, names);
        refuse("unknown verb \"" + word + "\"; " + (near.empty() ? "" : "did you mean \"" + near + "\"? ") +
               "known: " + join(names));
    }
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the end
    } catch (const CLI::Success&) {
        return [help = app.help()] { return std::fputs(help.c_str(), stdout), ExitCode::good; };
    } catch (const CLI::ParseError& e) {
        refuse(word + ": " + e.what() + "; see render_cloth " + word + " --help");
    }
    return actions[static_cast<std::size_t>(chosen - names.begin())];
}

}  // namespace cloth::cli
