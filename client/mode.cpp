#include "client/mode.h"

#include <array>
#include <string>

namespace gnomon::client {
namespace {

constexpr std::array kModes{Mode::sequential, Mode::queued};

}  // namespace

const char* to_string(Mode mode) {
  switch (mode) {
    case Mode::sequential: return "sequential";
    case Mode::queued: return "queued";
  }
  return "unknown";
}

Result<Mode> parse_mode(std::string_view name) {
  std::string allowed;
  for (const Mode mode : kModes) {
    if (name == to_string(mode)) return mode;
    allowed += (allowed.empty() ? "" : ", ") + std::string(to_string(mode));
  }
  return Error{std::string("unknown mode '").append(name) + "': allowed are " + allowed};
}

size_t max_in_flight(Mode mode) {
  // Four covers a round trip of 100 ms at 40 frames a second; a longer queue only adds frames that the server skips.
  return mode == Mode::sequential ? 1 : 4;
}

}  // namespace gnomon::client
