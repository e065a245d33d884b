// What a change of camera does to the picture: the figures from which the error of a prediction is expected.
#pragma once

#include "client/prediction/border.h"

namespace gnomon::client {

struct ImageMotion {
  double unseen = 0;  // share of the later picture that lies outside the buffer traced for the earlier camera
  double turn = 0;    // mean way of the picture's points, in parts of its width, by the camera's turning
  double shift = 0;   // the same by its moving, for points at the given distance
};

// From camera `traced`, border included, to `later`, of which the shown part counts. `distance`: metres to what is
// seen, roughly.
ImageMotion motion_between(const protocol::CameraView& traced, const protocol::CameraView& later,
                           const ViewSize& size, double distance);

}  // namespace gnomon::client
