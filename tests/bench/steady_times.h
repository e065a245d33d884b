// Times of frames and their passes on a device that is kept busy.
#pragma once

#include <map>
#include <string>

#include "gpu/picture/blocking_frame.h"

namespace gnomon::bench {

struct SteadyTimes {
  double frame_ms = 0;
  std::map<std::string, double> stage_ms;  // by the pass; passes of one name are added

  double shadow_stage_ms() const { return stage_ms.at("trace"); }
};

// Renders the camera's frame of what was reserved again and again until the device has been kept busy; medians of the
// second half. One frame, if it takes that long. Error: as BlockingFrame::render.
Result<SteadyTimes> steady_times(gpu::BlockingFrame& frame, const gpu::CameraView& camera, const TileGrid& grid);

}  // namespace gnomon::bench
