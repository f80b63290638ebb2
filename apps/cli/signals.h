#pragma once
// Ctrl-C, TERM and HUP: they end the program at once, or ask it to finish what it is at.

#include <atomic>

namespace cloth::cli {

/// Takes SIGINT, SIGTERM and SIGHUP over from the system, where they are not ignored: to be called before any
/// other thread starts. From then on one of them ends the program with exit code 130; its unfinished files go
/// with it.
void take_signals();

/// While it lives, a first signal raises its flag instead. One within half a second after it counts for the
/// same (a terminal and a shell may both send it), a later one ends the program at once.
class StopRequest {
  public:
    StopRequest();
    StopRequest(const StopRequest&) = delete;
    StopRequest& operator=(const StopRequest&) = delete;
    ~StopRequest();
    const std::atomic<bool>* flag() const;
};

}  // namespace cloth::cli
