#include "apps/workplace.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

namespace cloth::testing {

namespace fs = std::filesystem;

Workplace::Workplace() {
    spit(folder_ / "sheet.toml", R"(version = 1
description = "A small sheet that falls on a sphere."

[simulation]
frame_rate = 60
time_step = 0.005
integrator = "linearly_implicit_euler"
contact = "velocity_filter"

[[cloth]]
resolution = [12, 12]
rotate = [-90, 0, 0]
translate = [0, 0.27, 0]
fabric = {}

[[collider]]
shape = "sphere"
radius = 0.25
contact_offset = 0.01

[camera]
position = [0.4, 1.0, 2.6]
target = [0, 0, 0]

[output]
size = [64, 48]

[expect]
frames = [0, 3]
)");
}

Outcome Workplace::run(const std::string& arguments, const std::string& setting) const {
    const fs::path out = logs_ / "out", err = logs_ / "err";
    const std::string command = "cd '" + folder_.path().string() + "' && " + setting + " '" +
                                RENDER_CLOTH_BINARY + "' " + arguments + " >'" + out.string() + "' 2>'" +
                                err.string() + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(out), slurp(err)};
}

std::vector<std::string> Workplace::files(const std::string& below) const {
    std::vector<std::string> names;
    if (fs::exists(folder_ / below))
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / below))
            if (entry.is_regular_file())
                names.push_back(fs::relative(entry.path(), folder_ / below).string());
    std::sort(names.begin(), names.end());
    return names;
}

void Workplace::stand_in_for_ffmpeg(const std::string& script) const {
    fs::create_directories(folder_ / "bin");
    spit(folder_ / "bin/ffmpeg",
         "#!/bin/sh\ncase \"$*\" in *-version*) echo ffmpeg version fake; exit 0;; esac\n" + script + "\n");
    chmod((folder_ / "bin/ffmpeg").c_str(), 0755);
}

bool comes_true(const std::function<bool()>& condition, double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}

Started::Started(const Workplace& place, const std::string& arguments) {
    const std::string out = (logs_ / "out").string(), err = (logs_ / "err").string();
    const std::string line = "cd '" + place.path().string() + "' && PATH=\"$PWD/bin:$PATH\" exec '" +
                             RENDER_CLOTH_BINARY + "' " + arguments + " >'" + out + "' 2>'" + err +
                             "' </dev/null";
    pid_ = fork();
    if (pid_ == 0) {
        execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
        _exit(99);
    }
}

Started::~Started() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
}

void Started::send(int signal) const {
    REQUIRE(pid_ > 0);  // it has not ended: kill() takes -1 for all processes there are
    kill(pid_, signal);
}

Outcome Started::wait(double seconds) {
    int status = 0;
    const bool ended = comes_true([&] { return waitpid(pid_, &status, WNOHANG) == pid_; }, seconds);
    if (ended) pid_ = -1;
    return {!ended              ? -1
            : WIFEXITED(status) ? WEXITSTATUS(status)
                                : 128 + WTERMSIG(status),
            slurp(logs_ / "out"), slurp(logs_ / "err")};
}

void check_refusal(const Outcome& outcome, int code, const std::vector<std::string>& parts) {
    CHECK(outcome.code == code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Catch::StartsWith("render_cloth: "));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    for (const std::string& part : parts) CHECK_THAT(outcome.err, Catch::Contains(part));
}

nlohmann::json report_of(const Workplace& place, const std::string& out) {
    return nlohmann::json::parse(slurp(place / (out + "/report.json")));
}

std::vector<std::string> hashes(const nlohmann::json& report) {
    std::vector<std::string> list;
    for (const auto& frame : report["frames"]) list.push_back(frame["state_hash"]);
    return list;
}

}  // namespace cloth::testing
