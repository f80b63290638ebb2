#include "pipeline/formats/video.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "pipeline/formats/error.h"

extern char** environ;

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// A file descriptor that closes itself.
class Descriptor {
  public:
    explicit Descriptor(int number = -1) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() { close(); }
    void close() {
        if (number_ >= 0) ::close(std::exchange(number_, -1));
    }
    int get() const { return number_; }

  private:
    int number_;
};

/// An unnamed file in memory: takes a child's output without a thread that reads along.
Descriptor memory_file() {
    Descriptor file(::memfd_create("ffmpeg", MFD_CLOEXEC));
    if (file.get() < 0) throw std::system_error(errno, std::generic_category(), "memfd_create");
    return file;
}

std::string contents(const Descriptor& file) {
    std::string text;
    char buffer[4096];
    ssize_t got;
    while ((got = ::pread(file.get(), buffer, sizeof buffer, static_cast<off_t>(text.size()))) > 0)
        text.append(buffer, static_cast<std::size_t>(got));
    return text;
}

/// Starts ffmpeg in a process group of its own, so that a Ctrl-C on the terminal reaches this program alone.
pid_t start_ffmpeg(const std::vector<std::string>& arguments, int in, int out, int err) {
    std::vector<char*> argv;
    std::string program = "ffmpeg";
    argv.push_back(program.data());
    std::vector<std::string> copy = arguments;
    for (std::string& argument : copy) argv.push_back(argument.data());
    argv.push_back(nullptr);

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    if (in >= 0)
        posix_spawn_file_actions_adddup2(&files, in, 0);
    else
        posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out, 1);
    posix_spawn_file_actions_adddup2(&files, err, 2);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    pid_t child = -1;
    const int failure = ::posix_spawnp(&child, "ffmpeg", &files, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (failure != 0)
        throw Error(ExitCode::encoder,
                    fmt::format("cannot start ffmpeg ({}): install the package ffmpeg, or use --no-video",
                                std::strerror(failure)));
    return child;
}

/// Exit status as a shell would give it.
int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return 255;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The last lines of what ffmpeg said, as one.
std::string last_words(const std::string& said) {
    std::vector<std::string> lines;
    for (std::size_t start = 0; start < said.size();) {
        const std::size_t end = std::min(said.find_first_of("\r\n", start), said.size());
        if (end > start) lines.push_back(said.substr(start, end - start));
        start = end + 1;
    }
    std::string words;
    for (std::size_t i = lines.size() > 3 ? lines.size() - 3 : 0; i < lines.size(); ++i)
        words += (words.empty() ? "" : " | ") + lines[i];
    return words.empty() ? "it said nothing" : words;
}

/// Whether the file is boxes from its first to its last byte, an index (moov) and pictures (mdat) among them.
/// ffmpeg 5 may end with status 0 although the disk was full.
bool whole_movie(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::error_code failure;
    const std::uintmax_t length = fs::file_size(path, failure);
    if (!file || failure) return false;
    bool index = false, pictures = false;
    std::uintmax_t at = 0;
    while (at < length) {
        unsigned char head[16] = {};
        file.seekg(static_cast<std::streamoff>(at));
        file.read(reinterpret_cast<char*>(head), sizeof head);
        if (file.gcount() < 8) return false;
        file.clear();
        const auto big_endian = [&](int first, int count) {
            std::uintmax_t value = 0;
            for (int i = first; i < first + count; ++i) value = value << 8 | head[i];
            return value;
        };
        const std::uintmax_t size = big_endian(0, 4) == 1 ? big_endian(8, 8) : big_endian(0, 4);
        if (size < 8 || size > length - at) return false;
        const std::string_view kind(reinterpret_cast<const char*>(head) + 4, 4);
        index = index || kind == "moov";
        pictures = pictures || kind == "mdat";
        at += size;
    }
    return index && pictures;
}

}  // namespace

std::string ffmpeg_version() {
    const Descriptor out = memory_file(), err = memory_file();
    const int status = wait_for(start_ffmpeg({"-hide_banner", "-version"}, -1, out.get(), err.get()));
    if (status != 0) throw Error(ExitCode::encoder, "ffmpeg -version failed: " + last_words(contents(err)));
    const std::string text = contents(out);
    return text.substr(0, text.find('\n'));
}

struct VideoWriter::Impl {
    fs::path path, part;
    int width = 0, height = 0;
    pid_t child = -1;
    Descriptor pixels, words;
    std::vector<std::uint8_t> padded;

    [[noreturn]] void fail() {
        pixels.close();
        const int status = wait_for(std::exchange(child, -1));
        std::error_code ignored;
        fs::remove(part, ignored);
        throw Error(ExitCode::encoder, fmt::format("ffmpeg failed on {} (exit status {}): {}", path.string(),
                                                   status, last_words(contents(words))));
    }

    void send(const std::uint8_t* data, std::size_t size) {
        while (size > 0) {
            // MSG_NOSIGNAL: an encoder that ended early shows as an error here instead of ending the program.
            const ssize_t sent = ::send(pixels.get(), data, size, MSG_NOSIGNAL);
            if (sent < 0) {
                if (errno == EINTR) continue;
                fail();
            }
            data += sent;
            size -= static_cast<std::size_t>(sent);
        }
    }
};

VideoWriter::VideoWriter(const fs::path& path, int width, int height, const VideoOptions& options)
    : impl_(std::make_unique<Impl>()) {
    if (width < 1 || height < 1) throw std::invalid_argument("a movie needs at least one pixel");
    impl_->path = path;
    impl_->part = path.string() + ".part";
    impl_->width = width;
    impl_->height = height;
    const int even_width = width + width % 2, even_height = height + height % 2;
    const int threads =
        options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
    impl_->words = memory_file();

    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        throw std::system_error(errno, std::generic_category(), "socketpair");
    impl_->pixels = Descriptor(ends[0]);
    const Descriptor theirs(ends[1]);
    ::shutdown(ends[0], SHUT_RD);
    const std::vector<std::string> arguments = {
        "-hide_banner", "-nostdin", "-loglevel", "error", "-y",
        // Pictures as they are drawn …
        "-f", "rawvideo", "-pixel_format", "rgb0", "-video_size",
        fmt::format("{}x{}", even_width, even_height), "-framerate", fmt::format("{}", options.frame_rate),
        "-i", "pipe:0", "-an",
        // … to limited-range bt709, and told so: untagged, players guess by size and shift the colours.
        "-vf", "scale=in_range=full:out_range=tv:out_color_matrix=bt709,format=yuv420p", "-c:v", "libx264",
        "-preset", "veryfast", "-crf", fmt::format("{}", options.quality), "-threads",
        fmt::format("{}", threads), "-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709",
        "-color_trc", "bt709",
        // No dates and versions in the file: the same pictures make the same bytes.
        "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-movflags", "+faststart",
        "-f", "mp4", "file:" + impl_->part.string()};
    impl_->child = start_ffmpeg(arguments, theirs.get(), impl_->words.get(), impl_->words.get());
}

VideoWriter::~VideoWriter() {
    if (impl_->child < 0) return;
    ::kill(impl_->child, SIGKILL);
    wait_for(impl_->child);
    std::error_code ignored;
    fs::remove(impl_->part, ignored);
}

void VideoWriter::add(const render::Image& image) {
    Impl& m = *impl_;
    if (m.child < 0) throw std::logic_error("the movie has ended");
    if (image.width != m.width || image.height != m.height)
        throw std::invalid_argument(fmt::format("a picture of {}x{} in a movie of {}x{}", image.width,
                                                image.height, m.width, m.height));
    const bool odd_width = m.width % 2 != 0, odd_height = m.height % 2 != 0;
    if (!odd_width && !odd_height) {
        m.send(image.rgba.data(), image.rgba.size());
        return;
    }
    m.padded.clear();
    for (int y = 0; y < m.height + (odd_height ? 1 : 0); ++y) {
        const std::uint8_t* row = image.pixel(0, std::min(y, m.height - 1));
        const std::uint8_t* end = row + 4 * m.width;
        m.padded.insert(m.padded.end(), row, end);
        if (odd_width) m.padded.insert(m.padded.end(), end - 4, end);
    }
    m.send(m.padded.data(), m.padded.size());
}

void VideoWriter::finish() {
    Impl& m = *impl_;
    if (m.child < 0) throw std::logic_error("the movie has ended");
    m.pixels.close();
    const int status = wait_for(m.child);
    m.child = -1;
    const std::string said = contents(m.words);
    if (status != 0 || !whole_movie(m.part)) {
        std::error_code ignored;
        fs::remove(m.part, ignored);
        throw Error(ExitCode::encoder, fmt::format("ffmpeg failed on {} (exit status {}): {}",
                                                   m.path.string(), status, last_words(said)));
    }
    std::error_code failure;
    fs::rename(m.part, m.path, failure);
    if (failure) {
        std::error_code ignored;
        fs::remove(m.part, ignored);
        throw Error(ExitCode::encoder, "cannot write " + m.path.string() + ": " + failure.message());
    }
}

}  // namespace cloth::pipeline
