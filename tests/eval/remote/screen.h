// What was on a client's screen at each step of a flight, and what should have been there: so that pictures that never
// came, or came late, count against whoever sent them.
//
// A step is one camera. At its end the screen holds the newest picture that had come by then. It is judged beside the
// picture that was meant:
//   as old as the flight's pictures usually are (their median age, in steps), one step more at most: its own camera's
//   older, as a later one is lost or late: that of the camera that would usually have been on the screen by then
#pragma once

#include <cstdint>
#include <vector>

#include "client/media/png.h"
#include "common/clock.h"

namespace gnomon::remote {

struct ScreenPicture {
  uint32_t step = 0;  // whose camera it shows
  TimePoint at{};     // from when it was on the screen
  client::Picture picture;
};

struct Screen {
  TimePoint started{};  // step 0's camera was asked for
  double rate_hz = 30;
  uint32_t steps = 0;
  std::vector<ScreenPicture> pictures;  // in the order of their times
};

struct Seen {
  size_t picture = 0;  // of Screen::pictures
  uint32_t meant = 0;  // the step whose picture it is judged by
  bool late = false;
};

// For each step from `first` on; none before the first picture.
std::vector<Seen> seen_at_steps(const Screen& screen, uint32_t first);

}  // namespace gnomon::remote
