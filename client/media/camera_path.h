// The camera's pose as a function of time.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "client/prediction/border.h"
#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::client {

// A camera's path through a scene, repeated forever.
class CameraPath {
 public:
  // The scene's first camera animation; without one, a circle around the scene. Shares ownership of the scene.
  static CameraPath of_scene(const scenes::ScenePtr& scene);

  // For clients without the scene's file: a slow circle from the default camera, small against the scene.
  static CameraPath orbit(const protocol::SceneManifest& scene);

  double duration_seconds() const { return duration_seconds_; }  // > 0
  scenes::CameraPose at(double seconds) const;

 private:
  using PoseAt = std::function<scenes::CameraPose(double seconds)>;  // within [0, duration)
  CameraPath(double duration_seconds, PoseAt pose_at)
      : duration_seconds_(duration_seconds), pose_at_(std::move(pose_at)) {}

  double duration_seconds_;
  PoseAt pose_at_;
};

}  // namespace gnomon::client
