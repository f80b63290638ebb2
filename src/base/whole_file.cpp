#include "base/whole_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace cloth {

namespace fs = std::filesystem;

void write_whole_file(const fs::path& path, std::string_view bytes) {
    const fs::path part = path.string() + ".part";
    const auto fail = [&](int cause) {
        ::unlink(part.c_str());
        throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(cause));
    };
    const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) fail(errno);
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            const int cause = errno;
            ::close(file);
            fail(cause);
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    // Network and quota file systems report a full disk only here.
    if (::close(file) != 0) fail(errno);
    if (std::rename(part.c_str(), path.c_str()) != 0) fail(errno);
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
