#include "daemon/worker/task.h"

namespace gnomon::daemon {
namespace {

template <class Archive, class Task>
void visit_limits(Archive& a, Task& t) {
  a.plain(t.max_memory_bytes);
  a.plain(t.max_cpu_seconds);
  a.plain(t.niceness);
  a.enumerator(t.log_level, log::Level::off);
  a.enumerator(t.log_format, log::Format::json);
}

}  // namespace

Result<void> write_task(const WorkerTask& task, std::FILE* file) {
  scenes::PackWriter writer(file);
  visit_limits(writer, task);
  const auto* load = std::get_if<scenes::LoadTask>(&task.work);
  writer.boolean(load != nullptr);
  if (load) {
    scenes::write(writer, *load);
  } else {
    gpu::write(writer, std::get<gpu::BuildTask>(task.work));
  }
  if (writer.good() && std::fflush(file) == 0) return {};
  return Error{"the task cannot be written"};
}

Result<WorkerTask> read_task(std::span<const std::byte> bytes) {
  scenes::PackReader reader(bytes);
  WorkerTask task;
  visit_limits(reader, task);
  bool load = false;
  reader.boolean(load);
  if (load) {
    scenes::read(reader, task.work.emplace<scenes::LoadTask>());
  } else {
    gpu::read(reader, task.work.emplace<gpu::BuildTask>());
  }
  if (!reader.good()) return Error{"the task is cut off"};
  return task;
}

}  // namespace gnomon::daemon
