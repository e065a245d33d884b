// Gnomon's thin client on the same path and clock as the client for video: looks at every step, draws what is to be
// shown, keeps the pictures.
#pragma once

#include "client/cli/latency.h"
#include "client/media/camera_path.h"
#include "client/thin_client.h"
#include "tests/eval/remote/screen.h"

namespace gnomon::remote {

struct VisibilityPlan {
  client::StreamOptions stream;  // its Hello asks for the traced size
  client::ViewSize size;
  std::string device;
  uint32_t steps = 120;
  double rate_hz = 30, from_s = 0;
};

struct VisibilityFlight {
  Screen screen;
  client::Latencies response;  // from the camera's step to the drawn picture
  std::vector<size_t> ahead;   // x of each picture
  uint64_t received_bytes = 0, masks = 0;
  double seconds = 0;
};

// In mode auto. Blocks until every step was looked at. Error: no session, no device.
Result<VisibilityFlight> fly(const scenes::ScenePtr& scene, const VisibilityPlan& plan);

}  // namespace gnomon::remote
