// Loaded before the C library (LD_PRELOAD), it makes the disk full below the folder GNOMON_FULL_FOLDER while the file
// GNOMON_FAULTS/disk_full exists. Programs need no change.
#include <dlfcn.h>
#include <errno.h>
#include <stdarg.h>
#include <sys/uio.h>
#include <unistd.h>

#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

bool is_below(int descriptor, const char* folder) {
  char link[64];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  char path[PATH_MAX];
  const ssize_t length = readlink(link, path, sizeof path);
  const size_t expected = std::strlen(folder);
  return length > static_cast<ssize_t>(expected) && std::strncmp(path, folder, expected) == 0;
}

bool refused(int descriptor) {
  const char* faults = std::getenv("GNOMON_FAULTS");
  const char* folder = std::getenv("GNOMON_FULL_FOLDER");
  if (!faults || !folder || access((std::string(faults) + "/disk_full").c_str(), F_OK) != 0) return false;
  return is_below(descriptor, folder);
}

template <class F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* data, size_t bytes) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  if (!refused(descriptor)) return real(descriptor, data, bytes);
  errno = ENOSPC;
  return -1;
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  static const auto real = next<ssize_t (*)(int, const iovec*, int)>("writev");
  if (!refused(descriptor)) return real(descriptor, parts, count);
  errno = ENOSPC;
  return -1;
}
}
