// Unpredictable bytes from the kernel, for session ids and keys.
#pragma once

#include "common/ids.h"
#include "protocol/types.h"

namespace gnomon::daemon {

SessionId random_session_id();  // never 0
protocol::Bytes16 random_key();

}  // namespace gnomon::daemon
