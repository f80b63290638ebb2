#pragma once
// Work that may crash, hang or eat memory, in a process of its own.

#include <cstddef>
#include <functional>
#include <string>

#include <sys/types.h>

namespace cloth {

struct ChildLimits {
    int seconds = 60;        ///< of processor time; on the clock twice as long [s]; 0: no limit
    std::size_t memory = 0;  ///< beyond what this process has [byte]; 0: all; without effect under sanitizers
};

/// What `work` returns in a child of this process: nothing that it does is seen here, and it prints nothing.
/// Throws std::runtime_error: what `work` threw, or "ended with signal 11", "took longer than 60 s", "needs
/// more memory than 2.0 GB". `work` runs beside no other thread, so that it must not wait for one.
std::string in_child(const std::function<std::string()>& work, const ChildLimits& limits = {});

/// A child at work beside this process, one of several.
class Child {
  public:
    /// What `work` prints goes to the file `output`; nowhere where that is -1. Signals that this process
    /// blocks the child blocks too; it ends with the thread that made this. Throws std::system_error.
    Child(const std::function<std::string()>& work, const ChildLimits& limits, int output = -1);
    Child(Child&& other) noexcept;
    Child& operator=(Child&& other) noexcept;
    ~Child();  ///< ends it

    /// What can be read from when there is something for receive().
    int pipe() const { return pipe_; }
    /// Takes what has come of its answer, and waits where nothing has. Whether it may go on.
    bool receive();
    /// To be asked once, when receive() has said that it is over: as in_child().
    std::string answer();
    void end();  ///< at once

  private:
    pid_t id_ = -1;
    int pipe_ = -1;
    ChildLimits limits_;
    std::string bytes_;
};

/// Memory that this process and the children that it makes later see alike.
class SharedMemory {
  public:
    /// Zeros. Throws std::bad_alloc.
    explicit SharedMemory(std::size_t size);
    SharedMemory(const SharedMemory&) = delete;
    SharedMemory& operator=(const SharedMemory&) = delete;
    ~SharedMemory();
    void* data() const { return data_; }

  private:
    void* data_;
    std::size_t size_;
};

}  // namespace cloth
