#include "common/progress.h"

#include <unistd.h>

namespace gnomon {
namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(200);
constexpr auto kPlainInterval = std::chrono::seconds(3);

}  // namespace

Progress::Progress(std::FILE* out) : out_(out), terminal_(isatty(fileno(out)) == 1) {
  if (!terminal_) next_ = Clock::now() + kPlainInterval;  // short work needs no lines
}

Progress::~Progress() { clear(); }

void Progress::show(const std::string& line, TimePoint now) {
  std::fprintf(out_, terminal_ ? "\r\033[K%s" : "%s\n", line.c_str());
  std::fflush(out_);
  shown_ = true;
  next_ = now + (terminal_ ? Nanoseconds(kTerminalInterval) : Nanoseconds(kPlainInterval));
}

void Progress::clear() {
  if (terminal_ && shown_) std::fputs("\r\033[K", out_);
  shown_ = false;
}

}  // namespace gnomon
