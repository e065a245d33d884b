#include "daemon/security/random_bytes.h"

#include <sys/random.h>

#include <cerrno>
#include <cstdlib>

namespace gnomon::daemon {
namespace {

template <class T>
T random_value() {
  T value{};
  // Up to 256 bytes come whole and uninterrupted once the kernel's pool is ready; early in boot a signal may come.
  ssize_t got = 0;
  do got = getrandom(&value, sizeof value, 0);
  while (got < 0 && errno == EINTR);
  if (got != sizeof value) std::abort();  // no kernel that we run on lacks it: going on would be guessable
  return value;
}

}  // namespace

SessionId random_session_id() {
  SessionId id;
  while (id.value == 0) id = SessionId{random_value<uint64_t>()};
  return id;
}

}  // namespace gnomon::daemon
