#include "daemon/scenes/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <memory>
#include <string>

namespace gnomon::daemon {
namespace {

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

Result<void> write_to(int exchange, const WorkerTask& task) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(fdopen(dup(exchange), "wb"), std::fclose);
  if (!file) return because("the task cannot be written");
  return write_task(task, file.get());
}

// The process is not waited for yet. -1: it could not be started, see errno.
pid_t spawn(const std::filesystem::path& program, int exchange, int progress) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  // First to where neither is in the other's way.
  const int aside = exchange == kProgress + 1 ? kProgress + 2 : kProgress + 1;
  posix_spawn_file_actions_adddup2(&actions, progress, aside);
  posix_spawn_file_actions_adddup2(&actions, exchange, kExchange);
  posix_spawn_file_actions_adddup2(&actions, aside, kProgress);
  posix_spawn_file_actions_addclosefrom_np(&actions, kProgress + 1);
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
  // A worker's memory is all new and in large arrays: touched by huge pages where the kernel gives them on request.
  std::string pages = "GLIBC_TUNABLES=glibc.malloc.hugetlb=1";
  char* const environment[] = {pages.data(), nullptr};
  pid_t child = -1;
  errno = posix_spawn(&child, name.c_str(), &actions, &attributes, arguments, environment);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return errno == 0 ? child : -1;
}

enum class Ending { exited, stopped, too_long, unwatched };

// What the child has reported since the last call. A report that is no number is left out.
void hand_on(int reports, const OnProgress& on_progress) {
  Progress last;
  Progress next;
  bool any = false;
  while (read(reports, &next, sizeof next) == sizeof next) {
    any = std::isfinite(next.share);
    last = next;
  }
  if (any && on_progress) on_progress(static_cast<size_t>(last.light), std::clamp(last.share, 0.0, 1.0));
}

// Waits for the child to end, and kills it at the deadline or when `stop` is requested.
Ending wait_for(pid_t child, int reports, const Patience& patience, int& status) {
  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
  const Descriptor stopping(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  Ending ending = process && stopping ? Ending::too_long : Ending::unwatched;
  const std::stop_callback wake(patience.stop, [&] { eventfd_write(stopping.get(), 1); });
  pollfd watched[3] = {{process.get(), POLLIN, 0}, {stopping.get(), POLLIN, 0}, {reports, POLLIN, 0}};
  const auto deadline = std::chrono::steady_clock::now() + patience.time;
  while (ending == Ending::too_long) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    if (poll(watched, 3, static_cast<int>(left.count())) < 0 && errno != EINTR) break;
    if (watched[0].revents != 0)
      ending = Ending::exited;
    else if (watched[1].revents != 0)
      ending = Ending::stopped;
    if (watched[2].revents != 0) hand_on(reports, patience.on_progress);
    if (watched[2].revents & POLLHUP) watched[2].fd = -1;
  }
  if (ending != Ending::exited) kill(child, SIGKILL);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return ending;
}

std::string seconds(int64_t s) { return std::to_string(s) + " s"; }

// Why a worker that ended by itself gave no outcome.
Error failure(int status, const WorkerTask& task) {
  if (WIFEXITED(status)) return Error{"its reader gave up"};
  const std::string memory = std::to_string(task.max_memory_bytes >> 20) + " MiB";
  switch (WTERMSIG(status)) {
    case SIGXCPU: return Error{"it takes more than " + seconds(task.max_cpu_seconds) + " of processor time"};
    case SIGXFSZ: return Error{"it is larger than " + memory + " once it is read"};
    case SIGSYS: return Error{"its reader tried to do what it may not"};
    case SIGKILL: return Error{"its reader was killed, as by a lack of memory"};
    default: return Error{"its reader crashed (signal " + std::to_string(WTERMSIG(status)) + ")"};
  }
}

}  // namespace

Outcome::~Outcome() {
  if (data_) munmap(data_, size_);
}

Result<Outcome> run_worker(const std::filesystem::path& program, const WorkerTask& task, const Patience& patience) {
  const Descriptor exchange(memfd_create("gnomon-scene", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!exchange) return because("a scene's file in memory cannot be made");
  if (auto written = write_to(exchange.get(), task); !written) return written.error();
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return because("a pipe to its reader cannot be made");
  const Descriptor reports(ends[0]);
  pid_t child = -1;
  {
    const Descriptor reporting(ends[1]);
    child = spawn(program, exchange.get(), reporting.get());
    if (child < 0) return because("its reader cannot be started");
  }
  int status = 0;
  switch (wait_for(child, reports.get(), patience, status)) {
    case Ending::exited: break;
    case Ending::stopped: return Error{"nobody waits for it any more"};
    case Ending::too_long: return Error{"it takes more than " + seconds(patience.time.count() / 1000)};
    case Ending::unwatched: return Error{"its reader cannot be watched: too many files are open"};
  }
  if (status != 0) return failure(status, task);
  // The writer has ended: sealed, the file cannot change while it is read.
  if (fcntl(exchange.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL) != 0) {
    return because("a scene's file in memory cannot be sealed");
  }
  struct stat file {};
  if (fstat(exchange.get(), &file) != 0) return because("a scene's file in memory");
  const auto size = static_cast<size_t>(file.st_size);
  if (size == 0) return Outcome(nullptr, 0);
  void* const data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, exchange.get(), 0);
  if (data == MAP_FAILED) return because("a scene's file in memory cannot be mapped");
  return Outcome(data, size);
}

}  // namespace gnomon::daemon
