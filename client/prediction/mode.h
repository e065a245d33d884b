// How a client paces itself against the server's answers, and what it shows meanwhile (dissertation 2.3, 3.2, 3.3).
// n is the newest camera, n - p the newest one whose masks have arrived, x the number of frames predicted ahead.
#pragma once

#include <cstddef>
#include <string_view>

#include "common/result.h"

namespace gnomon::client {

enum class Mode {
  sequential,      // camera n, wait for visibility n, show n
  non_sequential,  // shows n with the masks of n - p as they are: misaligned while the camera moves
  queued,          // several cameras in flight; shows n - p with its own masks
  predicted,       // shows n - p + x with the masks of n - p, reprojected
  automatic,       // as predicted, with an x chosen for every frame (client/prediction/prediction_policy.h); "auto"
};

// Error: names the allowed modes.
Result<Mode> parse_mode(std::string_view name);
const char* to_string(Mode mode);

// How many cameras may be unanswered before the client waits.
size_t max_in_flight(Mode mode);

// True if frames are shown when their masks arrive; in the other modes, one is shown for every camera.
constexpr bool waits_for_masks(Mode mode) { return mode == Mode::sequential || mode == Mode::queued; }

}  // namespace gnomon::client
