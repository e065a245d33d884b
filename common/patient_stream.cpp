#include "common/patient_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <string>

namespace gnomon::log {
namespace {

constexpr int kPatienceMs = 100;
constexpr int kMostTries = 3;  // of a part that poll() says would be taken
constexpr size_t kAtOnce = 4096;

std::atomic<uint64_t> unwritten{0};

// Others write to a log's pipe too, and whether that waits is a property of what was opened. Sockets can't be opened again,
// and need not; a file would be written from its beginning.
int opened_again(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISFIFO(status.st_mode)) return -1;
  return open(("/proc/self/fd/" + std::to_string(descriptor)).c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
}

bool is_writable(int descriptor, int patience_ms) {
  pollfd asked{descriptor, POLLOUT, 0};
  const int found = poll(&asked, 1, patience_ms);
  return found > 0 && (asked.revents & (POLLOUT | POLLERR)) != 0;
}

// Neither a socket nor a pipe that was opened for it is waited for.
ssize_t write_some(int descriptor, std::string_view bytes) {
  const size_t count = std::min(bytes.size(), kAtOnce);
  const ssize_t sent = send(descriptor, bytes.data(), count, MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent < 0 && errno == ENOTSOCK ? ::write(descriptor, bytes.data(), count) : sent;
}

}  // namespace

PatientStream::PatientStream(int descriptor)
    : own_(opened_again(descriptor)), descriptor_(own_ >= 0 ? own_ : descriptor) {}

PatientStream::~PatientStream() {
  if (own_ >= 0) close(own_);
}

bool PatientStream::write_all(std::string_view bytes, size_t& written) const {
  int tries = 0;
  for (written = 0; written < bytes.size();) {
    const ssize_t some = write_some(descriptor_, bytes.substr(written));
    if (some > 0) {
      written += static_cast<size_t>(some);
      tries = 0;
    } else if (errno != EINTR) {
      const bool full = errno == EAGAIN && tries++ < kMostTries;
      if (!full || !is_writable(descriptor_, stuck_ ? 0 : kPatienceMs)) return false;
    }
  }
  return true;
}

bool PatientStream::write(std::string_view line) {
  size_t written = 0;
  if (torn_) torn_ = !write_all("\n", written);
  const bool whole = !torn_ && write_all(line, written);
  if (!torn_) torn_ = !whole && written > 0;
  stuck_ = !whole;
  return whole;
}

uint64_t unwritten_log_lines() { return unwritten.load(std::memory_order_relaxed); }

void count_unwritten_log_line() { unwritten.fetch_add(1, std::memory_order_relaxed); }

}  // namespace gnomon::log
