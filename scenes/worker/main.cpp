// gnomon-scene-worker: reads one scene file for the daemon, in a process that can do nothing else.
//
// Descriptor 3 is a file in memory: it holds the task (scenes/packed/packed_scene.h), and then the outcome in its place.
// The daemon starts this program; it has no options.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "scenes/loader.h"
#include "scenes/packed/packed_scene.h"
#include "scenes/worker/confinement.h"

namespace gnomon::scenes {
namespace {

constexpr int kExchange = 3;
constexpr int kNiceness = 10;  // frames have precedence

Result<LoadTask> take_task() {
  struct stat status {};
  if (fstat(kExchange, &status) != 0 || status.st_size <= 0) return Error{"it is started by gnomond alone"};
  std::vector<std::byte> bytes(static_cast<size_t>(status.st_size));
  if (pread(kExchange, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return Error{"the task cannot be read"};
  }
  if (ftruncate(kExchange, 0) != 0 || lseek(kExchange, 0, SEEK_SET) != 0)
    return Error{"the task cannot be removed"};
  return read_task(bytes);
}

Confinement confinement_of(const LoadTask& task) {
  Confinement to;
  to.folder = task.file.parent_path();
  to.max_cpu_seconds = task.max_cpu_seconds;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these map terabytes
  to.max_memory_bytes = task.max_memory_bytes;
#endif
  to.max_file_bytes = task.max_memory_bytes;
  return to;
}

Result<ScenePtr> load(const LoadTask& task) {
  try {
    return load_with_geometry(task.file, task.limits, task.motions);
  } catch (const std::bad_alloc&) {
    return Error{task.file.string() + ": reading it takes more memory than there may be"};
  }
}

Result<void> run() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  setpriority(PRIO_PROCESS, 0, kNiceness);
  const auto task = take_task();
  if (!task) return task.error();
  log::configure(task->log_level, task->log_format);
  std::FILE* exchange = fdopen(kExchange, "r+b");
  if (!exchange) return Error{"its descriptor is no file"};
  const auto confined = confine(confinement_of(*task));
  if (!confined) {
    return write_outcome(Error{"its reader cannot be confined: " + confined.error().message}, exchange);
  }
  return write_outcome(load(*task), exchange);
}

}  // namespace
}  // namespace gnomon::scenes

int main() {
  const auto done = gnomon::scenes::run();
  if (!done) std::fprintf(stderr, "gnomon-scene-worker: %s\n", done.error().message.c_str());
  // Without destructors: freeing a large scene takes time, and the file has been flushed.
  std::_Exit(done ? EXIT_SUCCESS : EXIT_FAILURE);
}
