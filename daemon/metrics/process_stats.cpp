#include "daemon/metrics/process_stats.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace gnomon::daemon {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// The kernel knows it as a time since the machine was booted, in field 22 of `stat`; /proc/stat, which has the time of
// the boot, is hidden from services.
double start_time_seconds() {
  constexpr int kFieldsAfterName = 19;
  std::ifstream stat("/proc/self/stat");
  stat.ignore(std::numeric_limits<std::streamsize>::max(), ')');
  std::string field;
  for (int i = 0; i < kFieldsAfterName; ++i) stat >> field;
  double ticks = 0;
  timespec since_boot{};
  if (!(stat >> ticks) || clock_gettime(CLOCK_BOOTTIME, &since_boot) != 0) return 0;
  const double uptime = static_cast<double>(since_boot.tv_sec) + static_cast<double>(since_boot.tv_nsec) * 1e-9;
  const double age = uptime - ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  return now.count() - age;
}

}  // namespace

ProcessStats process_stats() {
  static const double started = start_time_seconds();  // once, so that steps of the clock do not move it
  ProcessStats figures;
  figures.start_time_seconds = started;
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) == 0)
    figures.cpu_seconds = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) == 0) figures.max_files = static_cast<double>(files.rlim_cur);
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double value = 0;
    if (key == "VmSize:" && status >> value) figures.virtual_bytes = value * 1024;
    if (key == "VmRSS:" && status >> value) figures.resident_bytes = value * 1024;
    if (key == "Threads:" && status >> value) figures.threads = value;
    status.ignore(4096, '\n');
  }
  std::error_code error;
  const std::filesystem::directory_iterator open("/proc/self/fd", error);
  if (!error) figures.open_files = static_cast<double>(std::distance(begin(open), end(open)));
  return figures;
}

}  // namespace gnomon::daemon
