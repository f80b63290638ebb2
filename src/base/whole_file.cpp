#include "base/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <set>
#include <stdexcept>

#include "base/memory.h"

namespace cloth {

namespace fs = std::filesystem;

namespace {

struct Noted {
    std::recursive_mutex mutex;
    std::multiset<std::string> paths;
};
Noted& noted() {
    static auto* const files = new Noted;  // lives as long as any thread
    return *files;
}

[[noreturn]] void fail_to_write(const fs::path& path, int cause) {
    throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(cause));
}

/// A descriptor that closes itself.
struct Open {
    int number;
    ~Open() {
        if (number >= 0) ::close(number);
    }
};

int write_all(int file, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            return errno;
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
}

/// Network and quota file systems report a full disk only here.
int close_of(Open& file) {
    return ::close(std::exchange(file.number, -1)) != 0 ? errno : 0;
}

/// A new, empty file in `folder`, noted from its beginning.
FileToRemove make_part(const fs::path& target, const fs::path& folder) {
    static std::atomic<unsigned> count = 0;
    const std::string stem = (folder / target.filename()).string() + "." + std::to_string(::getpid()) + "-";
    const std::lock_guard lock(noted().mutex);
    while (true) {
        const fs::path part = stem + std::to_string(count++) + ".part";
        const Open file{::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666)};
        if (file.number >= 0) return FileToRemove(part);
        if (errno != EEXIST) fail_to_write(target, errno);
    }
}

/// Whether `target` is to be written to as it is. Throws where there is something that is not to be replaced.
bool is_stream(const fs::path& target) {
    struct stat itself = {}, meant = {};
    if (::lstat(target.c_str(), &itself) != 0) return false;  // nothing there: it is made
    const bool link = S_ISLNK(itself.st_mode);
    if (::stat(target.c_str(), &meant) != 0) meant = itself;
    if (S_ISDIR(meant.st_mode)) fail_to_write(target, EISDIR);
    if (S_ISCHR(meant.st_mode) || S_ISFIFO(meant.st_mode)) return true;
    if (S_ISREG(meant.st_mode) && !link) return false;
    std::error_code ignored;
    throw std::runtime_error(
        "cannot write " + target.string() + ": " +
        (link ? "is a link to " + fs::read_symlink(target, ignored).string() + "; give that file itself"
              : "is no regular file, device or pipe"));
}

}  // namespace

// ---------------------------------------------------------------- files that must not stay

FileToRemove::FileToRemove(fs::path path) : path_(std::move(path)) {
    if (path_.empty()) return;
    const std::lock_guard lock(noted().mutex);
    noted().paths.insert(path_.string());
}

void FileToRemove::keep() {
    if (path_.empty()) return;
    const std::lock_guard lock(noted().mutex);
    if (const auto found = noted().paths.find(path_.string()); found != noted().paths.end())
        noted().paths.erase(found);
    path_.clear();
}

FileToRemove::~FileToRemove() {
    if (path_.empty()) return;
    ::unlink(path_.c_str());
    keep();
}

void remove_noted_files() {
    noted().mutex.lock();  // for ever
    for (const std::string& path : noted().paths) ::unlink(path.c_str());
}

// ---------------------------------------------------------------- out

PartFile::PartFile(fs::path target)
    : target_(std::move(target)),
      stream_(is_stream(target_)),
      part_(make_part(target_, stream_ ? fs::temp_directory_path() : target_.parent_path())) {}

void PartFile::write(std::string_view bytes) {
    Open file{::open(part().c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC)};
    if (file.number < 0) fail_to_write(target_, errno);
    if (const int cause = write_all(file.number, bytes)) fail_to_write(target_, cause);
    if (const int cause = close_of(file)) fail_to_write(target_, cause);
}

void PartFile::sync() const {
    const Open file{::open(part().c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC)};
    if (file.number < 0 || ::fdatasync(file.number) != 0) fail_to_write(target_, errno);
}

void PartFile::finish() {
    if (!stream_) {
        is_stream(target_);  // once more: something may have come there since
        if (::rename(part().c_str(), target_.c_str()) != 0) fail_to_write(target_, errno);
        part_.keep();
        return;
    }
    const std::string bytes = read_whole_file(part());
    Open file{::open(target_.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC)};
    if (file.number < 0) fail_to_write(target_, errno);
    if (const int cause = write_all(file.number, bytes)) fail_to_write(target_, cause);
    if (const int cause = close_of(file)) fail_to_write(target_, cause);
    part_ = FileToRemove();
}

std::string target_of_part(const std::string& name) {
    constexpr std::string_view ending = ".part";
    if (!name.ends_with(ending)) return {};
    const std::string target = name.substr(0, name.size() - ending.size());
    const std::size_t dot = target.rfind('.');
    if (dot == std::string::npos) return {};
    const bool numbered =
        dot + 1 < target.size() && target.find_first_not_of("0123456789-", dot + 1) == std::string::npos;
    return numbered ? target.substr(0, dot) : target;
}

void write_whole_file(const fs::path& path, std::string_view bytes, Sync sync) {
    PartFile file(path);
    file.write(bytes);
    if (sync == Sync::yes) file.sync();
    file.finish();
}

LineFile::LineFile(const fs::path& path)
    : path_(path), file_(::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail_to_write(path_, errno);
}

LineFile::~LineFile() {
    ::close(file_);
}

void LineFile::add(const std::string& line, Sync sync) {
    if (const int cause = write_all(file_, line + "\n")) fail_to_write(path_, cause);
    if (sync == Sync::yes && ::fdatasync(file_) != 0) fail_to_write(path_, errno);
}

// ---------------------------------------------------------------- in

std::string read_whole_file(const fs::path& path) {
    // Without O_NONBLOCK a pipe that nobody writes to would not even open.
    const Open file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    const auto fail = [&](const std::string& cause) {
        throw std::runtime_error("cannot read " + path.string() + ": " + cause);
    };
    if (file.number < 0) fail(std::strerror(errno));
    struct stat what = {};
    if (::fstat(file.number, &what) != 0) fail(std::strerror(errno));
    if (S_ISDIR(what.st_mode)) fail(std::strerror(EISDIR));
    if (!S_ISREG(what.st_mode)) fail("is no regular file");
    const auto size = static_cast<std::size_t>(what.st_size);
    constexpr std::size_t small = std::size_t{1} << 26;  // fits anywhere
    if (const std::size_t there = size > small ? available_memory() : small; size > there)
        fail("is " + memory_text(static_cast<double>(size)) + " large; " +
             memory_text(static_cast<double>(there)) + " of memory are free");
    std::string bytes;
    char buffer[1 << 16];
    while (true) {
        const ssize_t got = ::read(file.number, buffer, sizeof buffer);
        if (got < 0) {
            if (errno == EINTR) continue;
            fail(std::strerror(errno));
        }
        if (got == 0) return bytes;
        bytes.append(buffer, static_cast<std::size_t>(got));
    }
}

}  // namespace cloth
