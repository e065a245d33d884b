// Unpredictable bytes from the kernel, for session ids.
#pragma once

#include "common/ids.h"

namespace gnomon::daemon {

SessionId random_session_id();  // never 0

}  // namespace gnomon::daemon
