// The program `render_cloth`: its command line names a verb (apps/verbs) with flags; the verb does the work.
// Whatever goes wrong is told in one line on standard error, and by the exit code.

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include "apps/cli/command_line.h"
#include "apps/cli/signals.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "base/whole_file.h"
#include "pipeline/formats/error.h"
#include "sim/contact/overlap.h"
#include "sim/scene/scene.h"

using namespace cloth;
using pipeline::ExitCode;

namespace {

/// So that no file that is opened takes the number of a standard stream, and is written to as one.
void occupy_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(stream, F_GETFD) < 0)
            ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // to use it fails, as before
}

/// Where nothing else can be done.
[[noreturn]] void end_by_fault() {
    remove_noted_files();
    constexpr std::string_view line =
        "render_cloth: ended by a fault that it cannot handle, or out of memory\n";
    [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, line.data(), line.size());
    ::_exit(static_cast<int>(ExitCode::other));
}

/// Why what was printed is not written; empty: it is. `cause`: what went wrong while it was printed, if
/// anything did. Where its reader went away, the program goes as one does.
std::string standard_output_fault(int cause) {
    errno = cause;
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
    cause = errno;
    if (cause == EPIPE) {
        std::signal(SIGPIPE, SIG_DFL);
        std::raise(SIGPIPE);
    }
    return std::string("cannot write to standard output") +
           (cause != 0 ? std::string(": ") + std::strerror(cause) : std::string());
}

}  // namespace

int main(int argc, char** argv) {
    occupy_standard_streams();
    std::signal(SIGXFSZ, SIG_IGN);  // a file size limit then shows as a write error with its cause
    std::signal(SIGPIPE, SIG_IGN);  // and so does a pipe without a reader
    std::set_terminate(end_by_fault);
    cli::take_signals();
    ExitCode code = ExitCode::other;
    std::string line;
    int cause = 0;
    try {
        const cli::Action work = cli::parse({argv + 1, argv + argc}, verbs::all());
        code = work();
    } catch (const pipeline::Error& e) {
        code = e.code;
        line = e.what();
    } catch (const OverlapError& e) {
        code = ExitCode::start_overlap;
        line = e.what();
    } catch (const SceneError& e) {
        code = ExitCode::invalid_scene;
        line = e.key.empty() ? e.what() : e.key + ": " + e.what();
    } catch (const std::bad_alloc&) {
        line = "out of memory";
    } catch (const std::system_error& e) {
        line = e.what();
        cause = e.code().value();
    } catch (const std::exception& e) {
        line = e.what();
    }
    if (const std::string fault = standard_output_fault(cause); !fault.empty()) {
        // What failed on the way for this reason says less.
        if (code == ExitCode::good || code == ExitCode::other) line = fault;
        if (code == ExitCode::good) code = ExitCode::other;
    }
    if (!line.empty()) std::fputs(("render_cloth: " + one_line(line) + "\n").c_str(), stderr);
    return static_cast<int>(code);
}
