#include "base/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace cloth {

namespace fs = std::filesystem;

namespace {

fs::path part_of(const fs::path& path) {
    return path.string() + ".part";
}

[[noreturn]] void fail_to_write(const fs::path& path, int cause) {
    ::unlink(part_of(path).c_str());
    throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(cause));
}

}  // namespace

void write_part(const fs::path& path, std::string_view bytes) {
    const int file = ::open(part_of(path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) fail_to_write(path, errno);
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            const int cause = errno;
            ::close(file);
            fail_to_write(path, cause);
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    // Network and quota file systems report a full disk only here.
    if (::close(file) != 0) fail_to_write(path, errno);
}

void finish_part(const fs::path& path) {
    if (std::rename(part_of(path).c_str(), path.c_str()) != 0) fail_to_write(path, errno);
}

void discard_part(const fs::path& path) {
    ::unlink(part_of(path).c_str());
}

void write_whole_file(const fs::path& path, std::string_view bytes) {
    write_part(path, bytes);
    finish_part(path);
}

std::string read_whole_file(const fs::path& path) {
    const auto fail = [&](int cause) {
        throw std::runtime_error("cannot read " + path.string() + ": " + std::strerror(cause));
    };
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) fail(errno);
    std::string bytes;
    char buffer[1 << 16];
    while (true) {
        const ssize_t got = ::read(file, buffer, sizeof buffer);
        if (got < 0) {
            if (errno == EINTR) continue;
            const int cause = errno;
            ::close(file);
            fail(cause);
        }
        if (got == 0) break;
        bytes.append(buffer, static_cast<std::size_t>(got));
    }
    ::close(file);
    return bytes;
}

}  // namespace cloth
