#include "base/child.h"

#include <fcntl.h>
#include <poll.h>
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

[[noreturn]] void be_child(const std::function<std::string()>& work, const ChildLimits& limits, int pipe) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, static_cast<std::size_t>(limits.seconds));
#ifndef CLOTH_WIDE_ADDRESS_SPACE
    if (limits.memory > 0) limit(RLIMIT_AS, address_space() + limits.memory);
#endif
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) ::dup2(nowhere, stream);
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

/// All that comes through the pipe; less where the clock runs out first.
std::string received(int pipe, int seconds, bool& late) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end = Clock::now() + std::chrono::seconds(seconds);
    std::string bytes;
    std::string buffer(1 << 16, '\0');
    while (true) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        late = left <= 0;
        if (late) return bytes;
        pollfd waiting{pipe, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, static_cast<int>(left));
        if (ready < 0 && errno != EINTR) return bytes;
        if (ready <= 0) continue;
        const ssize_t got = ::read(pipe, buffer.data(), buffer.size());
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return bytes;
        bytes.append(buffer.data(), static_cast<std::size_t>(got));
    }
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return 0;
    }
    return status;
}

}  // namespace

std::string in_child(const std::function<std::string()>& work, const ChildLimits& limits) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw std::system_error(errno, std::generic_category(), "cannot make a pipe");
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(ends[0]);
        be_child(work, limits, ends[1]);
    }
    ::close(ends[1]);
    if (child < 0) {
        ::close(ends[0]);
        throw std::system_error(errno, std::generic_category(), "cannot start a process");
    }
    bool late = false;
    std::string bytes;
    try {
        bytes = received(ends[0], 2 * limits.seconds, late);
    } catch (...) {  // out of memory
        ::kill(child, SIGKILL);
        wait_for(child);
        ::close(ends[0]);
        throw;
    }
    if (late) ::kill(child, SIGKILL);
    ::close(ends[0]);
    const int status = wait_for(child);

    std::uint64_t size = std::numeric_limits<std::uint64_t>::max();
    if (bytes.size() >= head_size) std::memcpy(&size, bytes.data() + 1, sizeof size);
    if (size == bytes.size() - head_size && bytes.size() >= head_size) {
        const Answer answer{bytes[0]};
        bytes.erase(0, head_size);
        if (answer == Answer::result) return bytes;
        if (answer == Answer::failure) throw std::runtime_error(bytes);
        throw std::runtime_error("needs more memory than " + memory_text(static_cast<double>(limits.memory)));
    }
    if (late || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU)))
        throw std::runtime_error("took longer than " + std::to_string(limits.seconds) + " s");
    throw std::runtime_error(WIFSIGNALED(status)
                                 ? "ended with signal " + std::to_string(WTERMSIG(status))
                                 : "ended with exit code " + std::to_string(WEXITSTATUS(status)));
}

}  // namespace cloth
