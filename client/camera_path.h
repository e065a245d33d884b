// Where the camera is at a time, and what of it goes over the wire.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::client {

// The picture shown, and the border traced around it (pixels in all, left and right or top and bottom together).
struct ViewSize {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t border_x = 0;
  uint32_t border_y = 0;

  uint32_t traced_width() const { return width + border_x; }
  uint32_t traced_height() const { return height + border_y; }
};

// The frustum of the traced buffer. The shown region stays what it is without a border: the focal length, in units
// of the buffer's width, shrinks by width / traced width (dissertation 3.4), and so it does for the height.
protocol::CameraView view_of(const scenes::CameraPose& pose, const ViewSize& size);

// A camera's way through a scene, repeated for ever.
class CameraPath {
 public:
  // The scene's first camera animation; without one, a circle around the scene. Keeps the scene.
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
