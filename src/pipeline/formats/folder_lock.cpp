#include "pipeline/formats/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace {

/// Of the running system: two with the same share their locks, whatever they call themselves.
std::string boot_id() {
    try {
        std::string id = read_whole_file("/proc/sys/kernel/random/boot_id");
        while (!id.empty() && id.back() == '\n') id.pop_back();
        return id;
    } catch (const std::runtime_error&) {
        return "unknown";
    }
}

/// "process 123 on the host loom, boot 5f…"
std::string own_name() {
    return fmt::format("process {} on the host {}, boot {}", ::getpid(), host_name(), boot_id());
}

/// Whether the one that a lock names may be alive although its lock can be had: on another computer, where
/// the file system does not carry locks from one to the other.
bool may_live_elsewhere(const std::string& name) {
    return name.find(", boot ") != std::string::npos && !name.ends_with(", boot " + boot_id()) &&
           name.find(" on the host " + host_name() + ", boot ") == std::string::npos;
}

/// Without what only programs want to know.
std::string for_people(const std::string& name) {
    return name.substr(0, name.find(", boot "));
}

/// What own_name() of another is, as its lock tells it.
std::string name_in(int file) {
    char text[400];
    const ssize_t got = ::pread(file, text, sizeof text, 0);
    return got > 0 ? std::string(text, static_cast<std::size_t>(got)) : "another process";
}

}  // namespace

std::string host_name() {
    char host[256] = {};
    if (::gethostname(host, sizeof host - 1) != 0) return "unknown";
    return host;
}

FolderLock::FolderLock(const std::filesystem::path& folder) {
    const std::filesystem::path path = folder / lock_name;
    while (true) {
        file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file_ < 0)
            throw Error(ExitCode::other,
                        "cannot write to the folder " + folder.string() + ": " + std::strerror(errno));
        // A file system that knows no locks gives none.
        if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            const std::string other = for_people(name_in(file_));
            ::close(file_);
            throw Error(ExitCode::other, fmt::format("{}: {} is writing there; wait for its end, or give "
                                                     "another folder",
                                                     folder.string(), other));
        }
        // Its owner may have removed the file between opening and locking.
        struct stat ours = {}, there = {};
        if (::fstat(file_, &ours) == 0 && ::stat(path.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
            ours.st_dev == there.st_dev)
            break;
        ::close(file_);
    }
    if (const std::string other = name_in(file_); may_live_elsewhere(other)) {
        ::close(file_);
        throw Error(ExitCode::other, fmt::format("{}: {} may be writing there; if it is not, remove {}",
                                                 folder.string(), for_people(other), path.string()));
    }
    name_ = FileToRemove(path);
    const std::string text = own_name();
    // Who cannot write it is without a name to others, no more.
    if (::ftruncate(file_, 0) == 0) [[maybe_unused]]
        const ssize_t written = ::pwrite(file_, text.data(), text.size(), 0);
}

FolderLock::~FolderLock() {
    name_ = FileToRemove();  // while it is locked
    ::close(file_);
}

}  // namespace cloth::pipeline
