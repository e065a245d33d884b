#include "daemon/metrics/process_stats.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace gnomon::daemon {

ProcessStats process_stats() {
  ProcessStats figures;
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double value = 0;
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
