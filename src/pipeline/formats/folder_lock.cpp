#include "pipeline/formats/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace {

/// "process 123 on the host loom"
std::string own_name() {
    char host[256] = {};
    if (::gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
    return fmt::format("process {} on the host {}", ::getpid(), host);
}

/// What own_name() of another is, as its lock tells it.
std::string name_in(int file) {
    char text[400];
    const ssize_t got = ::pread(file, text, sizeof text, 0);
    return got > 0 ? std::string(text, static_cast<std::size_t>(got)) : "another process";
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) {
    const std::filesystem::path path = folder / lock_name;
    while (true) {
        file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file_ < 0)
            throw Error(ExitCode::other,
                        "cannot write to the folder " + folder.string() + ": " + std::strerror(errno));
        // A file system that knows no locks gives none.
        if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            const std::string other = name_in(file_);
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
