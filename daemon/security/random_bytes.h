// Unpredictable bytes from the kernel, for session ids and for whatever a peer must not foresee.
#pragma once

#include <cstdint>

#include "common/ids.h"

namespace gnomon::daemon {

SessionId random_session_id();  // never 0
uint64_t random_number();       // all 64 bits

}  // namespace gnomon::daemon
