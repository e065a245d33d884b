#include "daemon/security/random_bytes.h"

#include <sys/random.h>

#include <cerrno>
#include <cstdlib>

namespace gnomon::daemon {
namespace {

template <class T>
T random_value() {
  T value{};
  // Up to 256 bytes are returned completely and without interruption once the kernel's pool is ready (getrandom(2));
  // early in boot a signal may interrupt the call.
  ssize_t got = 0;
  do got = getrandom(&value, sizeof value, 0);
  while (got < 0 && errno == EINTR);
  if (got != sizeof value) std::abort();  // every supported kernel has it; without it ids would be guessable
  return value;
}

}  // namespace

SessionId random_session_id() {
  SessionId id;
  while (id.value == 0) id = SessionId{random_value<uint64_t>()};
  return id;
}

uint64_t random_number() { return random_value<uint64_t>(); }

}  // namespace gnomon::daemon
