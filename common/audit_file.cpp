#include "common/audit_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <string_view>

namespace gnomon::log {
namespace {

// 0, or the system's error after `written` bytes.
int write_all(int descriptor, std::string_view text, size_t& written) {
  for (written = 0; written < text.size();) {
    const ssize_t count = write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno != EINTR) return errno;
    if (count > 0) written += static_cast<size_t>(count);
  }
  return 0;
}

struct Account {
  std::mutex mutex;
  uint64_t lines = 0;  // these are guarded by it
  int error = 0;
};

Account& account() {
  static Account instance;
  return instance;
}

}  // namespace

AuditFile::AuditFile(const std::string& file)
    : descriptor_(open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640)),
      open_error_(descriptor_ < 0 ? errno : 0) {}

AuditFile::~AuditFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

// A disk that fills takes a part of a line. What comes when there is room again begins a line of its own.
int AuditFile::append(const std::string& line) {
  if (open_error_ != 0) return open_error_;
  size_t written = 0;
  const std::string whole = torn_ ? "\n" + line : line;
  const int error = write_all(descriptor_, whole, written);
  if (written > 0) torn_ = whole[written - 1] != '\n';
  return error;
}

UnwrittenAudit unwritten_audit() {
  Account& all = account();
  std::lock_guard lock(all.mutex);
  return {all.lines, all.error == 0 ? "" : std::strerror(all.error)};
}

void count_audit_line(int error) {
  Account& all = account();
  std::lock_guard lock(all.mutex);
  all.error = error;
  if (error != 0) ++all.lines;
}

void forget_audit_error() {
  Account& all = account();
  std::lock_guard lock(all.mutex);
  all.error = 0;
}

}  // namespace gnomon::log
