// Work in a process of its own: its answer, and what becomes of it where it crashes, hangs or grows.

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include "base/child.h"
#include "base/memory.h"

using namespace cloth;
using Catch::Contains;

namespace {

std::string failure_of(const std::function<std::string()>& work, const ChildLimits& limits = {}) {
    try {
        in_child(work, limits);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return "none";
}

}  // namespace

TEST_CASE("a child's answer comes back whole, and what it throws too", "[child]") {
    CHECK(in_child([] { return std::string(); }).empty());
    const std::string large(10'000'000, 'x');
    CHECK(in_child([&] { return large; }) == large);
    int seen = 0;
    in_child([&] { return std::to_string(++seen); });
    CHECK(seen == 0);  // of the child alone
    CHECK(failure_of([]() -> std::string { throw std::runtime_error("no such thing"); }) == "no such thing");
}

TEST_CASE("a child that crashes, leaves or hangs is told of in words", "[child]") {
    CHECK(failure_of([]() -> std::string {
              ::kill(::getpid(), SIGKILL);
              return "";
          }) == "ended with signal 9");
    CHECK(failure_of([]() -> std::string { ::_exit(7); }) == "ended with exit code 7");
    CHECK(failure_of(
              []() -> std::string {
                  while (true) {
                      static volatile int i = 0;
                      i = i + 1;
                  }
              },
              {.seconds = 1}) == "took longer than 1 s");
    CHECK(failure_of(
              []() -> std::string {
                  while (true) ::pause();
              },
              {.seconds = 1}) == "took longer than 1 s");
}

TEST_CASE("memory is told in words, and some is there", "[child]") {
    CHECK(available_memory() > 10'000'000);
    CHECK(address_space() > 1'000'000);
    CHECK(memory_text(1.5e9) == "1.5 GB");
    CHECK(memory_text(2.2e7) == "22 MB");
    CHECK(memory_text(123e9) == "123 GB");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("a child that grows is stopped", "[child]") {
    CHECK(failure_of(
              []() -> std::string {
                  std::vector<std::string> all;
                  for (int i = 0; i < 100; ++i) all.emplace_back(10'000'000, 'x');
                  return "grown";
              },
              {.memory = 200'000'000}) == "needs more memory than 200 MB");
}
#endif

TEST_CASE("children work side by side, print into a file and share memory", "[child]") {
    const SharedMemory memory(sizeof(std::atomic<int>));
    auto* seen = new (memory.data()) std::atomic<int>(0);
    const std::string path = "child_output_" + std::to_string(::getpid());
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600);
    std::vector<Child> children;
    for (int i = 0; i < 3; ++i)
        children.emplace_back(
            [seen, i] {
                ++*seen;
                while (*seen < 3) ::usleep(1000);  // none ends before all have begun
                std::fputs("said\n", stderr);
                return std::to_string(i);
            },
            ChildLimits{.seconds = 30}, file);
    for (int i = 0; i < 3; ++i) {
        while (children[i].receive()) {
        }
        CHECK(children[i].answer() == std::to_string(i));
    }
    char text[100];
    CHECK(::pread(file, text, sizeof text, 0) == 15);
    ::close(file);
    ::unlink(path.c_str());

    Child endless(
        []() -> std::string {
            while (true) ::pause();
        },
        ChildLimits{.seconds = 0});
    endless.end();
    while (endless.receive()) {
    }
    CHECK_THROWS_WITH(endless.answer(), "ended with signal 9");
}
