#include "client/prediction/mode.h"

#include <array>
#include <string>

namespace gnomon::client {
namespace {

constexpr std::array kModes{Mode::sequential, Mode::non_sequential, Mode::queued, Mode::predicted, Mode::automatic};

}  // namespace

const char* to_string(Mode mode) {
  switch (mode) {
    case Mode::sequential: return "sequential";
    case Mode::non_sequential: return "non-sequential";
    case Mode::queued: return "queued";
    case Mode::predicted: return "predicted";
    case Mode::automatic: return "auto";
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
  // Without a rate of its own a client asks as fast as the window allows; four cover a round trip of 100 ms at 40
  // frames a second. One that predicts hides the round trip, whatever it is: 230 ms at 60 frames a second are 14.
  return mode == Mode::sequential ? 1 : mode == Mode::queued ? 4 : 24;
}

}  // namespace gnomon::client
