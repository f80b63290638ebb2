#include "pipeline/formats/video.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/whole_file.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// How long a wait for FFmpeg may last without a look at whether to stop.
constexpr std::chrono::milliseconds poll_time{50};

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

/// FFmpeg at work, in a process group of its own, so that a Ctrl-C on the terminal reaches this program
/// alone. It ends with this, and with the thread that started it.
class Child {
  public:
    Child() = default;
    /// `in` < 0: nothing to read. Throws Error(encoder) where it cannot be started.
    Child(const std::vector<std::string>& arguments, int in, const Descriptor& out, const Descriptor& err);
    Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
    Child& operator=(Child&& other) noexcept {
        std::swap(pid_, other.pid_);
        return *this;
    }
    ~Child() { end(); }

    bool runs() const { return pid_ > 0; }
    /// Exit status as a shell would give it. Throws Error(interrupted) where it is stopped.
    int wait(const std::atomic<bool>* stop);
    void end();

  private:
    pid_t pid_ = -1;
};

bool asked_to(const std::atomic<bool>* stop) {
    return stop != nullptr && stop->load();
}

/// In the child, where memory may not be asked for: becomes ffmpeg, or tells the cause.
[[noreturn]] void become_ffmpeg(char* const* argv, pid_t parent, int in, int out, int err, int tell) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // it died before
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGPIPE, SIG_DFL);
    if (::dup2(in, 0) >= 0 && ::dup2(out, 1) >= 0 && ::dup2(err, 2) >= 0) ::execvp(argv[0], argv);
    const int cause = errno;
    [[maybe_unused]] const ssize_t told = ::write(tell, &cause, sizeof cause);
    ::_exit(127);
}

Child::Child(const std::vector<std::string>& arguments, int in, const Descriptor& out,
             const Descriptor& err) {
    std::vector<std::string> words = {"ffmpeg"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    const Descriptor nothing(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe2");
    const Descriptor told(ends[0]);
    Descriptor tell(ends[1]);
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0)
        become_ffmpeg(argv.data(), parent, in < 0 ? nothing.get() : in, out.get(), err.get(), tell.get());
    int failure = pid_ < 0 ? errno : 0;
    tell.close();
    if (pid_ > 0) {
        ssize_t got;  // nothing, once it has become ffmpeg
        while ((got = ::read(told.get(), &failure, sizeof failure)) < 0 && errno == EINTR) {
        }
    }
    if (failure == 0) return;
    end();
    throw Error(ExitCode::encoder,
                fmt::format("cannot start ffmpeg ({}): install the package ffmpeg, or use --no-video",
                            std::strerror(failure)));
}

int Child::wait(const std::atomic<bool>* stop) {
    for (auto pause = std::chrono::milliseconds(1);; pause = std::min(2 * pause, poll_time)) {
        int status = 0;
        const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
        if (ended == pid_) {
            pid_ = -1;
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }
        if (ended < 0 && errno != EINTR) {
            pid_ = -1;
            return 255;
        }
        if (asked_to(stop)) {
            end();
            throw Error(ExitCode::interrupted, "interrupted: no movie was made");
        }
        std::this_thread::sleep_for(pause);
    }
}

void Child::end() {
    if (pid_ <= 0) return;
    ::kill(-pid_, SIGKILL);  // whatever it started too
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
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

/// Frames of the movie as its index and its packets have them, read by FFmpeg; none where it finds a fault.
/// It may end with status 0 although the disk was full.
std::optional<std::int64_t> frames_of(const fs::path& movie, const std::atomic<bool>* stop) {
    const Descriptor out = memory_file(), err = memory_file();
    Child reader({"-hide_banner", "-nostdin", "-loglevel", "error", "-i", "file:" + movie.string(), "-map",
                  "0:v:0", "-c", "copy", "-f", "null", "-progress", "pipe:1", "-"},
                 -1, out, err);
    if (reader.wait(stop) != 0 || !contents(err).empty()) return std::nullopt;
    const std::string said = contents(out);
    const std::size_t last = said.rfind("frame=");
    std::int64_t frames = 0;
    if (last == std::string::npos) return std::nullopt;
    std::from_chars(said.data() + last + 6, said.data() + said.size(), frames);
    return frames;
}

}  // namespace

std::string ffmpeg_version(const std::atomic<bool>* stop) {
    const Descriptor out = memory_file(), err = memory_file();
    const int status = Child({"-hide_banner", "-version"}, -1, out, err).wait(stop);
    if (status != 0) throw Error(ExitCode::encoder, "ffmpeg -version failed: " + last_words(contents(err)));
    const std::string text = contents(out);
    return text.substr(0, text.find('\n'));
}

struct VideoWriter::Impl {
    Impl(const fs::path& target, int w, int h, const std::atomic<bool>* asked)
        : path(target), file(target), width(w), height(h), stop(asked) {}

    fs::path path;
    PartFile file;
    int width = 0, height = 0;
    const std::atomic<bool>* stop;
    std::int64_t frames = 0;  ///< added
    Descriptor pixels, words;
    Child child;
    std::vector<std::uint8_t> padded;

    [[noreturn]] void fail(int status) {
        throw Error(ExitCode::encoder, fmt::format("ffmpeg failed on {} (exit status {}): {}", path.string(),
                                                   status, last_words(contents(words))));
    }

    void send(const std::uint8_t* data, std::size_t size) {
        while (size > 0) {
            // MSG_NOSIGNAL: an encoder that ended early shows as an error here instead of ending the program.
            const ssize_t sent = ::send(pixels.get(), data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
            if (sent >= 0) {
                data += sent;
                size -= static_cast<std::size_t>(sent);
                continue;
            }
            if (errno == EAGAIN || errno == EINTR) {
                if (asked_to(stop)) {
                    child.end();
                    throw Error(ExitCode::interrupted, "interrupted: no movie was made");
                }
                pollfd room{pixels.get(), POLLOUT, 0};
                ::poll(&room, 1, static_cast<int>(poll_time.count()));
                continue;
            }
            pixels.close();
            fail(child.wait(stop));
        }
    }
};

VideoWriter::VideoWriter(const fs::path& path, int width, int height, const VideoOptions& options) {
    if (width < 1 || height < 1) throw std::invalid_argument("a movie needs at least one pixel");
    try {
        impl_ = std::make_unique<Impl>(path, width, height, options.stop);
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::encoder, e.what());
    }
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
        "-f", "mp4", "file:" + impl_->file.part().string()};
    impl_->child = Child(arguments, theirs.get(), impl_->words, impl_->words);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::add(const render::Image& image) {
    Impl& m = *impl_;
    if (!m.child.runs()) throw std::logic_error("the movie has ended");
    if (image.width != m.width || image.height != m.height)
        throw std::invalid_argument(fmt::format("a picture of {}x{} in a movie of {}x{}", image.width,
                                                image.height, m.width, m.height));
    ++m.frames;
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
    if (!m.child.runs()) throw std::logic_error("the movie has ended");
    m.pixels.close();
    if (const int status = m.child.wait(m.stop)) m.fail(status);
    const std::optional<std::int64_t> frames = frames_of(m.file.part(), m.stop);
    if (!frames) m.fail(0);
    if (*frames != m.frames)
        throw Error(ExitCode::encoder,
                    fmt::format("ffmpeg failed on {}: it wrote {} frames of {}: {}", m.path.string(), *frames,
                                m.frames, last_words(contents(m.words))));
    try {
        m.file.finish();
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::encoder, e.what());
    }
}

}  // namespace cloth::pipeline
