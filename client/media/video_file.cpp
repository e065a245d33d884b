#include "client/media/video_file.h"

#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

extern char** environ;

namespace gnomon::client {

struct VideoFile::State {
  std::string name;
  VideoOptions options;
  int input = -1;  // ffmpeg's standard input
  pid_t ffmpeg = -1;
  uint32_t width = 0, height = 0;

  ~State() { (void)end(); }

  Error failed(const std::string& why) const { return Error{"cannot write '" + name + "': " + why}; }
  Result<void> start();
  // Closes ffmpeg's input, waits for it to end and returns its status, as of waitpid().
  int end() {
    if (input >= 0) ::close(std::exchange(input, -1));
    int status = 0;
    if (ffmpeg > 0) ::waitpid(std::exchange(ffmpeg, -1), &status, 0);
    return status;
  }
};

namespace {

std::vector<std::string> ffmpeg_arguments(const std::string& file, const VideoOptions& options, uint32_t width,
                                          uint32_t height) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  const std::string even = "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=out_color_matrix=bt709:out_range=tv";
  return {"ffmpeg",
          "-y",
          "-nostdin",
          "-loglevel",
          "error",
          "-f",
          "rawvideo",
          "-pix_fmt",
          "rgba",
          "-s",
          size,
          "-r",
          std::to_string(options.fps),
          "-i",
          "pipe:0",
          "-vf",
          even,
          "-c:v",
          "libx264",
          "-crf",
          std::to_string(options.quality),
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-movflags",
          "+faststart",
          file};
}

}  // namespace

VideoFile::VideoFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoFile::~VideoFile() = default;
VideoFile::VideoFile(VideoFile&&) noexcept = default;
VideoFile& VideoFile::operator=(VideoFile&&) noexcept = default;

Result<VideoFile> VideoFile::create(const std::filesystem::path& file, const VideoOptions& options) {
  auto state = std::make_unique<State>();
  state->name = file.string();
  state->options = options;
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) return state->failed("there is no such folder");
  return VideoFile(std::move(state));
}

// ffmpeg's input is a socket instead of a pipe: sending to one whose reader has ended need not raise SIGPIPE.
Result<void> VideoFile::State::start() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return failed(std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  // A process group of its own: Ctrl-C at the terminal reaches this program alone, which then ends the file in order.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  auto arguments = ffmpeg_arguments(name, options, width, height);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const int error = ::posix_spawnp(&ffmpeg, "ffmpeg", &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  input = ends[0];
  if (error == 0) return {};
  ffmpeg = -1;
  return failed(error == ENOENT ? "there is no program ffmpeg (Debian: apt-get install ffmpeg)"
                                : std::strerror(error));
}

Result<void> VideoFile::add(const Picture& picture) {
  State& s = *state_;
  if (s.width == 0) {
    s.width = picture.width;
    s.height = picture.height;
    if (auto started = s.start(); !started) return started;
  }
  if (picture.width != s.width || picture.height != s.height)
    return s.failed("a picture of another size than the first");
  for (size_t done = 0; done < picture.rgba.size();) {
    const ssize_t sent = ::send(s.input, &picture.rgba[done], picture.rgba.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return s.failed(errno == EPIPE ? "ffmpeg has ended" : std::strerror(errno));
    done += static_cast<size_t>(sent);
  }
  return {};
}

Result<void> VideoFile::close() {
  State& s = *state_;
  if (s.width == 0) return s.failed("there was no picture");
  const int status = s.end();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return s.failed("ffmpeg failed");
  return {};
}

}  // namespace gnomon::client
