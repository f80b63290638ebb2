#include "base/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/memory.h"

// Sanitizers reserve more address space than there is memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CLOTH_WIDE_ADDRESS_SPACE
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define CLOTH_WIDE_ADDRESS_SPACE
#endif
#endif

namespace cloth {
namespace {

/// How an answer begins: with one of these and its length.
enum class Answer : char { result, failure, no_memory };
constexpr std::size_t head_size = 1 + sizeof(std::uint64_t);

void limit(int what, std::size_t value) {
    rlimit old{};
    ::getrlimit(what, &old);
    const rlim_t lower = old.rlim_max == RLIM_INFINITY ? value : std::min<rlim_t>(value, old.rlim_max);
    const rlimit wanted{lower, old.rlim_max};
    ::setrlimit(what, &wanted);
}

void send(int pipe, Answer answer, const std::string& text) {
    std::array<char, head_size> head{static_cast<char>(answer)};
    const std::uint64_t size = text.size();
    std::memcpy(head.data() + 1, &size, sizeof size);
    const auto put = [pipe](const char* bytes, std::size_t count) {
        while (count > 0) {
            const ssize_t written = ::write(pipe, bytes, count);
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) ::_exit(1);
            bytes += written;
            count -= static_cast<std::size_t>(written);
        }
    };
    put(head.data(), head.size());
    put(text.data(), text.size());
}

[[noreturn]] void be_child(const std::function<std::string()>& work, const ChildLimits& limits, int pipe,
                           int output) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    limit(RLIMIT_CORE, 0);
    if (limits.seconds > 0) limit(RLIMIT_CPU, static_cast<std::size_t>(limits.seconds));
#ifndef CLOTH_WIDE_ADDRESS_SPACE
    if (limits.memory > 0) limit(RLIMIT_AS, address_space() + limits.memory);
#endif
    const int nowhere = ::open("/dev/null", O_RDWR);
    ::dup2(nowhere, 0);
    for (const int stream : {1, 2}) ::dup2(output >= 0 ? output : nowhere, stream);
    try {
        send(pipe, Answer::result, work());
    } catch (const std::bad_alloc&) {
        send(pipe, Answer::no_memory, {});
    } catch (const std::exception& e) {
        send(pipe, Answer::failure, e.what());
    } catch (...) {
        send(pipe, Answer::failure, "failed");
    }
    ::_exit(0);  // nothing of this process is cleared away twice
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return 0;
    }
    return status;
}

std::runtime_error too_long(const ChildLimits& limits) {
    return std::runtime_error("took longer than " + std::to_string(limits.seconds) + " s");
}

}  // namespace

Child::Child(const std::function<std::string()>& work, const ChildLimits& limits, int output)
    : limits_(limits) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw std::system_error(errno, std::generic_category(), "cannot make a pipe");
    id_ = ::fork();
    if (id_ == 0) {
        ::close(ends[0]);
        be_child(work, limits, ends[1], output);
    }
    const int cause = errno;
    ::close(ends[1]);
    pipe_ = ends[0];
    if (id_ < 0) {
        ::close(pipe_);
        throw std::system_error(cause, std::generic_category(), "cannot start a process");
    }
}

Child::Child(Child&& other) noexcept
    : id_(std::exchange(other.id_, -1)),
      pipe_(std::exchange(other.pipe_, -1)),
      limits_(other.limits_),
      bytes_(std::move(other.bytes_)) {}

Child& Child::operator=(Child&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(pipe_, other.pipe_);
    std::swap(limits_, other.limits_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

Child::~Child() {
    if (id_ > 0) {
        end();
        wait_for(id_);
    }
    if (pipe_ >= 0) ::close(pipe_);
}

void Child::end() {
    if (id_ > 0) ::kill(id_, SIGKILL);
}

bool Child::receive() {
    std::array<char, 1 << 16> buffer;
    const ssize_t got = ::read(pipe_, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) return true;
    if (got <= 0) return false;
    bytes_.append(buffer.data(), static_cast<std::size_t>(got));
    return true;
}

std::string Child::answer() {
    const int status = wait_for(std::exchange(id_, -1));
    std::uint64_t size = std::numeric_limits<std::uint64_t>::max();
    if (bytes_.size() >= head_size) std::memcpy(&size, bytes_.data() + 1, sizeof size);
    if (size == bytes_.size() - head_size && bytes_.size() >= head_size) {
        const Answer kind{bytes_[0]};
        bytes_.erase(0, head_size);
        if (kind == Answer::result) return std::move(bytes_);
        if (kind == Answer::failure) throw std::runtime_error(bytes_);
        throw std::runtime_error(limits_.memory > 0 ? "needs more memory than " +
                                                          memory_text(static_cast<double>(limits_.memory))
                                                    : "out of memory");
    }
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) throw too_long(limits_);
    throw std::runtime_error(WIFSIGNALED(status)
                                 ? "ended with signal " + std::to_string(WTERMSIG(status))
                                 : "ended with exit code " + std::to_string(WEXITSTATUS(status)));
}

std::string in_child(const std::function<std::string()>& work, const ChildLimits& limits) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end = Clock::now() + std::chrono::seconds(2 * limits.seconds);
    Child child(work, limits);
    while (true) {
        int wait = -1;  // [ms]; for ever
        if (limits.seconds > 0) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
            if (left.count() <= 0) throw too_long(limits);
            wait = static_cast<int>(left.count());
        }
        pollfd waiting{child.pipe(), POLLIN, 0};
        if (::poll(&waiting, 1, wait) > 0 && !child.receive()) return child.answer();
    }
}

SharedMemory::SharedMemory(std::size_t size)
    : data_(::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)), size_(size) {
    if (data_ == MAP_FAILED) throw std::bad_alloc();
}

SharedMemory::~SharedMemory() {
    ::munmap(data_, size_);
}

}  // namespace cloth
