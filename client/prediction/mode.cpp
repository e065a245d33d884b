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
  // A client without a rate of its own asks as fast as this window allows; four cameras cover a round trip of 100 ms at
  // 40 frames a second. A client that predicts hides any round trip: 230 ms at 60 frames a second are 14 cameras.
  return mode == Mode::sequential ? 1 : mode == Mode::queued ? 4 : 24;
}

}  // namespace gnomon::client
