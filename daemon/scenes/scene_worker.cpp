#include "daemon/scenes/scene_worker.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <new>
#include <span>

#include "scenes/packed/packed_scene.h"

namespace gnomon::daemon {
namespace {

constexpr int kExchange = 3;  // as scenes/worker/main.cpp has it

Error because(const char* what) { return Error{std::string(what) + ": " + std::strerror(errno)}; }

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

// A read-only view of a file in memory.
class Mapping {
 public:
  Mapping(int fd, size_t size) : size_(size) {
    if (size > 0) data_ = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (*this) munmap(data_, size_);
  }
  explicit operator bool() const { return data_ != MAP_FAILED; }
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), size_}; }

 private:
  void* data_ = MAP_FAILED;
  size_t size_;
};

Result<void> write_task(int exchange, const scenes::LoadTask& task) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(fdopen(dup(exchange), "wb"), std::fclose);
  if (!file) return because("the task cannot be written");
  return scenes::write_task(task, file.get());
}

// The process is not waited for yet. -1: it could not be started, see errno.
pid_t spawn(const std::filesystem::path& program, int exchange) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, exchange, kExchange);
  posix_spawn_file_actions_addclosefrom_np(&actions, kExchange + 1);
  // The daemon's own masks and handlers are none of the worker's.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string name = program.string();
  char* const arguments[] = {name.data(), nullptr};
  char* const environment[] = {nullptr};
  pid_t child = -1;
  errno = posix_spawn(&child, name.c_str(), &actions, &attributes, arguments, environment);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return errno == 0 ? child : -1;
}

enum class Ending { exited, stopped, too_long };

// Waits for the child to end, and kills it at the deadline or when `stop` is requested.
Ending wait_for(pid_t child, std::chrono::milliseconds time, const std::stop_token& stop, int& status) {
  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
  const Descriptor stopping(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  const std::stop_callback wake(stop, [&] { eventfd_write(stopping.get(), 1); });
  pollfd watched[2] = {{process.get(), POLLIN, 0}, {stopping.get(), POLLIN, 0}};
  const auto deadline = std::chrono::steady_clock::now() + time;
  Ending ending = Ending::too_long;
  while (ending == Ending::too_long) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    if (poll(watched, 2, static_cast<int>(left.count())) < 0 && errno != EINTR) break;
    if (watched[0].revents != 0)
      ending = Ending::exited;
    else if (watched[1].revents != 0)
      ending = Ending::stopped;
  }
  if (ending != Ending::exited) kill(child, SIGKILL);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return ending;
}

std::string seconds(std::chrono::seconds time) { return std::to_string(time.count()) + " s"; }

// Why a worker that ended by itself gave no outcome.
Error failure(int status, const SceneWorkerOptions& options) {
  if (WIFEXITED(status)) return Error{"its reader gave up"};
  const std::string memory = std::to_string(options.max_memory_bytes >> 20) + " MiB";
  switch (WTERMSIG(status)) {
    case SIGXCPU: return Error{"reading it takes more than " + seconds(options.max_time) + " of processor time"};
    case SIGXFSZ: return Error{"it is larger than " + memory + " once it is read"};
    case SIGSYS: return Error{"its reader tried to do what it may not"};
    case SIGKILL: return Error{"its reader was killed, as by a lack of memory"};
    default: return Error{"its reader crashed (signal " + std::to_string(WTERMSIG(status)) + ")"};
  }
}

}  // namespace

Result<scenes::ScenePtr> load_in_worker(const SceneWorkerOptions& options, const scenes::SceneSource& source,
                                        const scenes::LoadLimits& limits, std::stop_token stop) {
  const Descriptor exchange(memfd_create("gnomon-scene", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!exchange) return because("a scene's file in memory cannot be made");
  const scenes::LoadTask task{.file = source.file,
                              .motions = source.motions,
                              .limits = limits,
                              .max_memory_bytes = options.max_memory_bytes,
                              .max_cpu_seconds = static_cast<uint32_t>(options.max_time.count()),
                              .log_level = options.log_level,
                              .log_format = options.log_format};
  if (auto written = write_task(exchange.get(), task); !written) return written.error();
  const pid_t child = spawn(options.program, exchange.get());
  if (child < 0) return because("its reader cannot be started");
  int status = 0;
  switch (wait_for(child, 2 * options.max_time, stop, status)) {
    case Ending::exited: break;
    case Ending::stopped: return Error{"nobody waits for it any more"};
    case Ending::too_long: return Error{"reading it takes more than " + seconds(2 * options.max_time)};
  }
  if (status != 0) return failure(status, options);
  // The writer has ended: sealed, the file cannot change while it is read.
  if (fcntl(exchange.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL) != 0) {
    return because("a scene's file in memory cannot be sealed");
  }
  struct stat file {};
  if (fstat(exchange.get(), &file) != 0) return because("a scene's file in memory");
  const Mapping mapping(exchange.get(), static_cast<size_t>(file.st_size));
  if (!mapping) return because("a scene's file in memory cannot be mapped");
  try {
    return scenes::read_outcome(mapping.bytes(), limits);
  } catch (const std::bad_alloc&) {
    return Error{"there is not enough memory for it"};
  }
}

}  // namespace gnomon::daemon
