// A client on a link whose latency changes, in virtual time: which x it chose, how wrong its pictures were and how old.
// The link is tests/tools/netsim's; the errors are those that the path's own masks gave (path_errors.h).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/prediction/border.h"
#include "client/prediction/prediction_policy.h"
#include "scenes/scene.h"

namespace gnomon::eval {

struct LinkPlan {
  scenes::ScenePtr scene;
  client::ViewSize size;  // what was asked for: with the border whose errors are used
  double fps = 60;
  uint32_t first = 0;                                        // frame of the path
  const std::vector<std::vector<double>>* errors = nullptr;  // for each frame and x, as PathErrors::frames
  Nanoseconds render = std::chrono::milliseconds(8);         // of the server, for a frame
  size_t frame_bytes = 40'000;
  uint64_t seed = 1;
  std::vector<int> round_trips_ms;  // the link's, one after the other
  double phase_s = 4;               // each
};

struct Outcome {
  std::string policy;
  double parameter = 0;
  double error = 0;        // mean share of wrong bits of what was shown
  double response_ms = 0;  // mean age of what was shown
  double mean_x = 0;
};

Outcome play(const LinkPlan& plan, std::unique_ptr<client::PredictionPolicy> ahead);

}  // namespace gnomon::eval
