// How a client paces itself against the server's answers (dissertation 2.3, 3.2).
#pragma once

#include <cstddef>
#include <string_view>

#include "common/result.h"

namespace gnomon::client {

enum class Mode {
  sequential,  // camera n, wait for visibility n, shade n
  queued,      // several cameras in flight; an answer is shaded with the G-buffer of its own camera
};

// Error: what is allowed.
Result<Mode> parse_mode(std::string_view name);
const char* to_string(Mode mode);

// How many cameras may be unanswered before the client waits.
size_t max_in_flight(Mode mode);

}  // namespace gnomon::client
