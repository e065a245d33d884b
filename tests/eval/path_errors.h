// The dissertation's 4.1.1: a camera path flown with every frame's masks at hand, each frame predicted from those
// before it, bits counted against its own. One frame is rendered with the widest border; narrower ones are windows of
// it, as all have pixels of one size.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "client/prediction/border.h"
#include "client/prediction/prediction_error.h"
#include "client/prediction/prediction_policy.h"
#include "common/result.h"
#include "scenes/scene.h"

namespace gnomon::eval {

struct PathPlan {
  client::ViewSize size;  // with the widest border
  double fps = 60;
  uint32_t first = 0;  // frames of the path, at that rate
  uint32_t count = 0;
  uint32_t stride = 1;  // every so many of them are predicted
  std::string device;
  std::filesystem::path cache;  // of light buffers; if empty, none
};

// A border as the dissertation names it, at 1920x1080, and as it is in proportion here.
struct Border {
  std::string name;
  uint32_t x = 0, y = 0;
  bool by_motion = false;  // lies where the camera turns to
};
std::vector<Border> borders_of(uint32_t width, uint32_t height);

inline constexpr size_t kMostAhead = client::kMostAhead;

struct PathErrors {
  uint32_t lights = 0;
  std::vector<Border> borders;
  // Sums over the path, for each border and x = 1...kMostAhead.
  std::vector<std::vector<client::PredictionError>> sums;
  // Share of wrong bits for each frame and x, of border `kept`; below 0: not measured.
  std::vector<std::vector<double>> frames;
  std::string device, driver;
};

// The border whose errors are kept for each frame: the dissertation's widest in use.
inline constexpr const char* kKeptBorder = "128x72";

// `said`: progress, frame by frame.
Result<PathErrors> measure_path(const scenes::ScenePtr& scene, const PathPlan& plan,
                                const std::function<void(uint32_t done)>& said);

// Where the camera is in frame `i`.
scenes::CameraPose pose_of(const scenes::ScenePtr& scene, double fps, uint32_t i);

}  // namespace gnomon::eval
