#pragma once
// What the program writes about itself for other programs: a page for man, and completion for bash.

#include <string>
#include <vector>

#include "apps/cli/command_line.h"

namespace cloth::cli {

/// render_cloth(1), in the language of man pages.
std::string manual_page(const std::vector<KnownVerb>& verbs);

/// A script that bash sources: completes verbs, flags, the words that these take, scenes, folders and files.
std::string bash_completion(const std::vector<KnownVerb>& verbs);

}  // namespace cloth::cli
