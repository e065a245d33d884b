// gnomon-scene-worker: does for the daemon what a scene's file decides the length of, in a process that can do nothing
// else: reads a scene, or builds what traces it.
//
// The daemon starts this program; it has no options. See task.h for its descriptors.
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "daemon/worker/confinement.h"
#include "daemon/worker/task.h"
#include "scenes/loader.h"

namespace gnomon::daemon {
namespace {

Result<WorkerTask> take_task() {
  struct stat status {};
  if (fstat(kExchange, &status) != 0 || status.st_size <= 0) return Error{"it is started by gnomond alone"};
  const auto size = static_cast<size_t>(status.st_size);
  void* const bytes = mmap(nullptr, size, PROT_READ, MAP_SHARED, kExchange, 0);
  if (bytes == MAP_FAILED) return Error{"the task cannot be read"};
  auto task = read_task({static_cast<const std::byte*>(bytes), size});
  munmap(bytes, size);
  if (ftruncate(kExchange, 0) != 0 || lseek(kExchange, 0, SEEK_SET) != 0)
    return Error{"the task cannot be removed"};
  return task;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

Confinement confinement_of(const WorkerTask& task) {
  Confinement to;
  if (const auto* load = std::get_if<scenes::LoadTask>(&task.work)) to.folder = load->file.parent_path();
  to.max_cpu_seconds = task.max_cpu_seconds;
  if (!kSanitized) to.max_memory_bytes = task.max_memory_bytes;  // their runtimes map terabytes
  to.max_file_bytes = task.max_memory_bytes;
  return to;
}

// What cannot be written is lost: the daemon shows an older share.
void report(size_t light, double share) {
  const Progress progress{light, share};
  [[maybe_unused]] const ssize_t written = write(kProgress, &progress, sizeof progress);
}

Result<void> done(const scenes::LoadTask& task, std::FILE* exchange) {
  Result<scenes::ScenePtr> scene = Error{task.file.string() + ": reading it takes more memory than there may be"};
  try {
    scene = scenes::load_with_geometry(task.file, task.limits, task.motions, task.colours,
                                       [](double share) { report(0, share); });
  } catch (const std::bad_alloc&) {  // the reason stands already
  }
  return scenes::write_outcome(scene, exchange);
}

Result<void> done(const gpu::BuildTask& task, std::FILE* exchange) {
  const gpu::StructureBuildsPtr builds = gpu::builds_here();
  if (task.kind == gpu::BuildTask::Kind::bvh) return gpu::write_outcome(builds->bvh(task.own_mesh), exchange);
  gpu::light_buffer::BuildSettings settings;
  settings.detail = task.detail;
  settings.budget_bytes = task.budget_bytes;
  settings.progress = report;
  return gpu::write_outcome(builds->light_buffer(task.own_mesh, task.bounds, task.lights, settings), exchange);
}

// Each arena reserves 64 MiB of address space, and by default there are eight for each core: on a large machine they would
// be all that this process may have.
void keep_arenas_few() {
  constexpr int kArenas = 8;
  mallopt(M_ARENA_MAX, kArenas);
}

// Where the machine has no memory left, this process goes and not the daemon. A kernel that refuses keeps its own order.
void offer_to_be_killed_first() {
  if (std::FILE* const score = std::fopen("/proc/self/oom_score_adj", "w")) {
    std::fputs("1000", score);
    std::fclose(score);
  }
}

Result<void> run() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto task = take_task();
  if (!task) return task.error();
  offer_to_be_killed_first();
  keep_arenas_few();
  [[maybe_unused]] const int niceness = nice(task->niceness);
  log::configure(task->log_level, task->log_format);
  std::FILE* exchange = fdopen(kExchange, "r+b");
  if (!exchange) return Error{"its descriptor is no file"};
  const Confinement to = confinement_of(*task);
  if (const auto confined = kSanitized ? limit_resources(to) : confine(to); !confined) {
    const Error why{"its reader cannot be confined: " + confined.error().message};
    return scenes::write_outcome(why, exchange);  // a reason is written alike for all kinds of work
  }
  return std::visit([&](const auto& work) { return done(work, exchange); }, task->work);
}

}  // namespace
}  // namespace gnomon::daemon

int main() {
  const auto done = gnomon::daemon::run();
  if (!done) std::fprintf(stderr, "gnomon-scene-worker: %s\n", done.error().message.c_str());
  // Without destructors: freeing a large scene takes time, and the file has been flushed.
  std::_Exit(done ? EXIT_SUCCESS : EXIT_FAILURE);
}
