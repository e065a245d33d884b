// The file of the audit log, and what it did not take.
#pragma once

#include <cstdint>
#include <string>

namespace gnomon::log {

// Appends lines, each with one write, so that lines of several holders of the file do not mix. One thread at a time.
class AuditFile {
 public:
  explicit AuditFile(const std::string& file);  // made with mode 0640 where it is not there
  ~AuditFile();
  AuditFile(const AuditFile&) = delete;
  AuditFile& operator=(const AuditFile&) = delete;

  // 0, or the system's error: the file then has none of `line`, or the beginning of it on a line of its own.
  int append(const std::string& line);

 private:
  const int descriptor_;
  const int open_error_;  // of the system; 0: it is open
  bool torn_ = false;     // the file ends within a line
};

// Lines of the audit log since the process began that its file did not take, as on a full disk.
struct UnwrittenAudit {
  uint64_t lines = 0;
  std::string why;  // of the last line that was to be written, where that failed; if empty, it was written
};

// Any thread.
UnwrittenAudit unwritten_audit();
void count_audit_line(int error);  // 0: it was written
void forget_audit_error();         // of a file that is no longer the audit log's

}  // namespace gnomon::log
