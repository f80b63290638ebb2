#include "apps/cli/signals.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "base/whole_file.h"
#include "pipeline/formats/error.h"

namespace cloth::cli {
namespace {

std::atomic<bool> stop_wanted = false;
std::atomic<int> requests = 0;  ///< that live

[[noreturn]] void end_at_once() {
    remove_noted_files();
    const std::string_view line =
        ::isatty(STDERR_FILENO) == 1 ? "\r\033[Krender_cloth: interrupted\n" : "render_cloth: interrupted\n";
    [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, line.data(), line.size());
    ::_exit(static_cast<int>(pipeline::ExitCode::interrupted));
}

[[noreturn]] void watch(const sigset_t signals) {
    using Clock = std::chrono::steady_clock;
    std::optional<Clock::time_point> first;
    while (true) {
        int signal = 0;
        if (::sigwait(&signals, &signal) != 0) continue;
        if (requests == 0) end_at_once();
        if (!first) {
            first = Clock::now();
            stop_wanted = true;
        } else if (Clock::now() - *first > std::chrono::milliseconds(500)) {
            end_at_once();
        }
    }
}

}  // namespace

void take_signals() {
    sigset_t signals, before;
    sigemptyset(&signals);
    for (const int each : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action = {};
        ::sigaction(each, nullptr, &action);
        // nohup, or a shell's job in the background
        if (action.sa_handler != SIG_IGN) sigaddset(&signals, each);
    }
    ::pthread_sigmask(SIG_BLOCK, &signals, &before);
    try {
        std::thread(watch, signals).detach();
    } catch (const std::system_error&) {
        ::pthread_sigmask(SIG_SETMASK, &before, nullptr);  // they end the program as they always do
    }
}

StopRequest::StopRequest() {
    ++requests;
}
StopRequest::~StopRequest() {
    --requests;
}
const std::atomic<bool>* StopRequest::flag() const {
    return &stop_wanted;
}

}  // namespace cloth::cli
