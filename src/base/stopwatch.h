#pragma once
// Wall time. No computation looks at it.

#include <chrono>

namespace cloth {

class Stopwatch {
  public:
    /// Since it was made [s].
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

/// Adds the time of its scope to `seconds`.
class TimedScope {
  public:
    explicit TimedScope(double& seconds) : seconds_(seconds) {}
    ~TimedScope() { seconds_ += watch_.seconds(); }
    TimedScope(const TimedScope&) = delete;
    TimedScope& operator=(const TimedScope&) = delete;

  private:
    double& seconds_;
    Stopwatch watch_;
};

}  // namespace cloth
