// Exit statuses of the command-line programs of client/.
#pragma once

namespace gnomon::client {

enum class Exit : int {
  done = 0,
  failed = 1,       // standard error says why
  wrong_usage = 2,  // of the command line
  kept_out = 3,     // the server's operator closed the session and keeps this client out for a time
  unanswered = 3,   // of gnomon-load: cameras stayed without an answer
};

}  // namespace gnomon::client
