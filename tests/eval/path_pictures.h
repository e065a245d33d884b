// Pictures along a camera path, shaded with each frame's own masks or with those of x frames before: examples to look
// at, and videos to compare (dissertation 4.1.3).
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/media/png.h"
#include "client/prediction/border.h"
#include "common/result.h"
#include "gpu/picture/reference_view.h"
#include "scenes/scene.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::eval {

class PathPictures {
 public:
  struct Plan {
    scenes::ScenePtr scene;
    client::ViewSize size;
    double fps = 60;
    std::string device;
    std::filesystem::path cache;  // of light buffers; if empty, none
  };
  static Result<PathPictures> create(const Plan& plan);

  // PREFIX-fresh.png, PREFIX-predicted.png, PREFIX-difference.png (grey as fresh, red where they differ).
  Result<void> write_example(uint32_t frame, uint32_t x, const std::string& prefix);

  // PREFIX-X.rgb for each x: frames one after the other, three bytes a pixel. The first ones, which have none x before
  // them, are their own.
  Result<void> write_videos(uint32_t first, uint32_t count, const std::vector<uint32_t>& every_x,
                            const std::string& prefix, const std::function<void(uint32_t done)>& said);

 private:
  struct Frame {
    uint32_t number = 0;
    protocol::CameraView camera;
    gpu::SeenMasks seen;
  };

  Result<Frame> trace(uint32_t number);
  Result<client::Picture> shade(const Frame& now, const Frame& seen);

  Plan plan_;
  std::unique_ptr<gpu::SurfaceProbe> probe_;
  std::unique_ptr<gpu::ReferenceView> view_;
  float exposure_ = 1;
};

}  // namespace gnomon::eval
