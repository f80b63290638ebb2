// The program `render_cloth`: its command line names a verb (apps/verbs) with flags; the verb does the work.
// Whatever goes wrong is told in one line on standard error, and by the exit code.

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

#include "apps/cli/command_line.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/formats/error.h"
#include "sim/contact/overlap.h"
#include "sim/scene/scene.h"

using namespace cloth;
using pipeline::ExitCode;

int main(int argc, char** argv) {
    // A file size limit then shows as a write error with its cause.
    std::signal(SIGXFSZ, SIG_IGN);
    ExitCode code = ExitCode::other;
    std::string line;
    try {
        const cli::Action work = cli::parse({argv + 1, argv + argc}, verbs::all());
        return static_cast<int>(work());
    } catch (const pipeline::Error& e) {
        code = e.code;
        line = e.what();
    } catch (const OverlapError& e) {
        code = ExitCode::start_overlap;
        line = e.what();
    } catch (const SceneError& e) {
        code = ExitCode::invalid_scene;
        line = e.key.empty() ? e.what() : e.key + ": " + e.what();
    } catch (const std::exception& e) {
        line = e.what();
    }
    std::fflush(stdout);
    fmt::print(stderr, "render_cloth: {}\n", one_line(line));
    return static_cast<int>(code);
}
