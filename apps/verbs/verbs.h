#pragma once
// What the program can do. A new verb is a file here, NAME.cpp with `cli::Verb NAME()`, and a row.

#include <vector>

#include "apps/cli/command_line.h"

/// In the order of the help; the first is meant where none is named.
#define CLOTH_VERBS(row)                                                                             \
    row(run) row(simulate) row(resume) row(render) row(encode) row(sheet) row(compare_video)         \
        row(export_mesh) row(report) row(audit) row(gc) row(sweep) row(compare) row(bless) row(list) \
            row(validate) row(version)

namespace cloth::verbs {

#define CLOTH_VERB(name) cli::Verb name();
CLOTH_VERBS(CLOTH_VERB)
#undef CLOTH_VERB

inline std::vector<cli::Verb> all() {
#define CLOTH_VERB(name) name(),
    return {CLOTH_VERBS(CLOTH_VERB)};
#undef CLOTH_VERB
}

}  // namespace cloth::verbs
