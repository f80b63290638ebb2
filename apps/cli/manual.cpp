#include "apps/cli/manual.h"

#include <fmt/format.h>

#include <string_view>

#include "base/text.h"
#include "pipeline/formats/build_info.h"

namespace cloth::cli {
namespace {

/// Text as man takes it: no line begins with a point, and dashes and backslashes are themselves.
std::string man_text(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '\\') {
            escaped += "\\e";
        } else if (c == '-') {
            escaped += "\\-";
        } else {
            escaped += c;
        }
    }
    return escaped.starts_with('.') || escaped.starts_with('\'') ? "\\&" + escaped : escaped;
}

/// "--format NAME", its parts as a page sets them.
std::string man_flag(const KnownFlag& flag) {
    std::string text = "\\fB" + man_text(flag.name) + "\\fR";
    if (!flag.name.starts_with('-'))
        text = "\\fI" + man_text(flag.value) + "\\fR";
    else if (!flag.value.empty())
        text += " \\fI" + man_text(flag.value) + "\\fR";
    return text;
}

struct ExitWords {
    ExitCode code;
    const char* meaning;
};
constexpr ExitWords exit_words[] = {
    {ExitCode::good, "good"},
    {ExitCode::other, "anything else"},
    {ExitCode::usage, "usage"},
    {ExitCode::invalid_scene, "scene or mesh invalid"},
    {ExitCode::not_converged, "did not converge"},
    {ExitCode::start_overlap, "overlap at the start"},
    {ExitCode::golden_mismatch, "golden mismatch"},
    {ExitCode::encoder, "FFmpeg failed or is missing"},
    {ExitCode::interrupted, "interrupted"},
};

}  // namespace

std::string manual_page(const std::vector<KnownVerb>& verbs) {
    std::string text = fmt::format(
        ".TH RENDER_CLOTH 1 \"\" \"render_cloth {}\" \"User Commands\"\n.SH NAME\nrender_cloth \\- simulate "
        "cloth, draw every frame, and make a movie of it\n.SH SYNOPSIS\n",
        pipeline::program_version());
    for (const KnownVerb& verb : verbs) {
        text += fmt::format(".br\n.B render_cloth {}\n", man_text(verb.name));
        for (const KnownFlag& flag : verb.flags)
            if (flag.required) text += man_flag(flag) + "\n";
        text += ".RI [ flags ]\n";
    }
    text += fmt::format(".SH DESCRIPTION\nWhere no verb is named, {} is meant.\n", verbs.front().name);
    for (const KnownVerb& verb : verbs) {
        text += fmt::format(".SS {}\n{}.\n", man_text(verb.name), man_text(verb.help));
        for (const KnownFlag& flag : verb.flags) {
            text += fmt::format(".TP\n{}\n{}", man_flag(flag), man_text(flag.help));
            if (!flag.choices.empty()) text += fmt::format(": {}", man_text(join(flag.choices)));
            text += flag.required ? ". Required.\n" : ".\n";
        }
    }
    text += ".SH EXIT STATUS\n";
    for (const ExitWords& each : exit_words)
        text += fmt::format(".TP\n{}\n{}\n", static_cast<int>(each.code), each.meaning);
    return text +
           ".SH ENVIRONMENT\n.TP\nRENDER_CLOTH_ASSETS\nA folder that is looked in first for "
           "scenes/NAME.toml\n";
}

std::string bash_completion(const std::vector<KnownVerb>& verbs) {
    std::vector<std::string> names;
    std::string flags, choices;
    for (const KnownVerb& verb : verbs) {
        names.push_back(verb.name);
        std::vector<std::string> words{"--help"};
        for (const KnownFlag& flag : verb.flags) {
            if (flag.name.starts_with('-')) {
                words.push_back(flag.name);
            } else {
                words.insert(words.end(), flag.choices.begin(), flag.choices.end());
            }
            // One that takes no word is followed by the next flag.
            const bool takes_word = flag.name.starts_with('-') && !flag.value.empty();
            if (!takes_word) continue;
            std::string words_of_flag;  // of a number there are none
            if (!flag.choices.empty())
                words_of_flag = fmt::format("compgen -W '{}' -- \"$word\"", join(flag.choices, " "));
            if (flag.value == "DIR") words_of_flag = "compgen -d -- \"$word\"";
            if (flag.name == "--file") words_of_flag = "compgen -f -- \"$word\"";
            if (flag.name == "--scene")
                words_of_flag =
                    "compgen -W \"$(\"${COMP_WORDS[0]}\" list scenes 2>/dev/null | cut -d' ' -f1)\" -- "
                    "\"$word\"; "
                    "compgen -f -X '!*.toml' -- \"$word\"";
            choices += fmt::format("        {}:{}) COMPREPLY=($({})); return ;;\n", verb.name, flag.name,
                                   words_of_flag);
        }
        flags += fmt::format("        {}) words='{}' ;;\n", verb.name, join(words, " "));
    }
    return fmt::format(
        "# Completion for bash of render_cloth {0}; written by render_cloth list completion\n"
        "_render_cloth() {{\n"
        "    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} verb={1} words\n"
        "    case ${{COMP_WORDS[1]}} in\n        {2}) verb=${{COMP_WORDS[1]}} ;;\n    esac\n"
        "    case $verb:$before in\n{3}    esac\n"
        "    case $verb in\n{4}    esac\n"
        "    [ \"$COMP_CWORD\" = 1 ] && words=\"{5} --version $words\"\n"
        "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n}}\n"
        "complete -o filenames -F _render_cloth render_cloth\n",
        pipeline::program_version(), names.front(), join(names, "|"), choices, flags, join(names, " "));
}

}  // namespace cloth::cli
