// Work in a process of its own: its answer, and what becomes of it where it crashes, hangs or grows.

#include <catch2/catch.hpp>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

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
