// A descriptor whose reader may stop reading, as a log's that is a pipe: whoever writes waits for it once, and not for ever.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace gnomon::log {

// Writes lines. While the reader takes nothing, a line is left out at once. One thread at a time for each object.
class PatientStream {
 public:
  explicit PatientStream(int descriptor);  // stays the caller's
  ~PatientStream();
  PatientStream(const PatientStream&) = delete;
  PatientStream& operator=(const PatientStream&) = delete;

  // False: the reader has not taken the line, or the beginning of it alone; the next line then begins anew.
  bool write(std::string_view line);

 private:
  bool write_all(std::string_view bytes, size_t& written) const;

  const int own_;         // of a pipe: opened once more, for writes that never wait; else -1
  const int descriptor_;  // that is written to
  bool stuck_ = false;    // the last line was left out
  bool torn_ = false;     // what was written ends within a line
};

// Lines of the log since the process began that nobody took. Any thread.
uint64_t unwritten_log_lines();
void count_unwritten_log_line();

}  // namespace gnomon::log
