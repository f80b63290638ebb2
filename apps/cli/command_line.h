#pragma once
// Verbs and their flags, read by CLI11. Its headers are slow to compile: command_line.cpp alone includes
// them.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/formats/error.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cloth::cli {

using pipeline::ExitCode;

/// Throws Error(usage).
[[noreturn]] void refuse(const std::string& line);

/// As it stands in the help: `--frames N   Number of frames`. A name without dashes is known by its place.
struct Flag {
    std::string name, value, help;
    bool required = false;
};

/// A flag as it was added, and the words that it takes, where there are but some.
struct KnownFlag : Flag {
    std::vector<std::string> choices;
};

/// The flags of one verb. A flag that is not given leaves its variable alone; a bad value is refused as
/// "--count: Value 0 not in range 1 to 1000".
class Flags {
  public:
    explicit Flags(CLI::App& app) : app_(app) {}

    /// All that were added.
    const std::vector<KnownFlag>& known() const { return known_; }

    void yes(const std::string& name, bool& given, const std::string& help);
    void text(const Flag& flag, std::string& value);
    void integer(const Flag& flag, int& value, int least, int greatest);
    void number(const Flag& flag, double& value, double least, double greatest);
    /// One of some names.
    void choice(const Flag& flag, std::string& value, const std::vector<std::string>& names);
    /// Exactly `count` words behind each other.
    void words(const Flag& flag, std::vector<std::string>& values, int count);
    /// As often as it is given.
    void repeated(const Flag& flag, std::vector<std::string>& values);

  private:
    CLI::App& app_;
    std::vector<KnownFlag> known_;
};

using Action = std::function<ExitCode()>;

/// A word of the command line with flags of its own. A new one is a file in apps/verbs and a row in verbs.h.
struct Verb {
    std::string name, help;
    std::function<Action(Flags&)> add;  ///< adds the flags; returns what is done once they are read
};

/// A verb whose flags are in a struct of its own.
template <class Values>
Verb verb(const std::string& name, const std::string& help, void (*add)(Flags&, Values&),
          ExitCode (*run)(const Values&)) {
    return {name, help, [add, run](Flags& flags) -> Action {
                auto values = std::make_shared<Values>();
                add(flags, *values);
                return [values, run] { return run(*values); };
            }};
}

/// A verb and its flags, to be written about.
struct KnownVerb {
    std::string name, help;
    std::vector<KnownFlag> flags;
};
std::vector<KnownVerb> known_verbs(const std::vector<Verb>& verbs);

/// What the words (without the program's name) ask for. The first is the verb; where it is a flag or nothing,
/// the first of `verbs` is meant; --version is the verb version. Throws Error(usage), saying what would be
/// right. To print help is an action as well.
Action parse(std::vector<std::string> words, const std::vector<Verb>& verbs);

}  // namespace cloth::cli
