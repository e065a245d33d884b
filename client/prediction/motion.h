// How a change of the camera moves the picture: the figures from which the error of a prediction is estimated.
#pragma once

#include "client/prediction/border.h"

namespace gnomon::client {

struct ImageMotion {
  double unseen = 0;  // share of the later picture that lies outside the buffer traced for the earlier camera
  double turn = 0;    // mean distance that the camera's turning moves the picture's points, in picture widths
  double shift = 0;   // the same by its translation, for points at the given distance
};

// From camera `traced`, border included, to `later`, of which the shown part counts. `distance` is the approximate
// distance of what is seen, in metres.
ImageMotion motion_between(const protocol::CameraView& traced, const protocol::CameraView& later,
                           const ViewSize& size, double distance);

}  // namespace gnomon::client
