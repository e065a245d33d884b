// What the native client shows of counts, alone and over several masks: the shares of lights and of ambient light, read
// back from its own pictures of a scene in which every surface is white. Pictures have 8 bits, which is an error of 0.002.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gpu/picture/reference_view.h"
#include "tests/bench/bench_scenes.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::bench {

inline constexpr double kFrameHz = 30;  // of clients that move

// Of the scene's masks with these samples.
LightPlanes planes_of(const scenes::Scene& scene, SampleCounts samples);

class ClientShares {
 public:
  static Result<ClientShares> create(const std::string& device, const scenes::ScenePtr& scene);

  // Traces by `probe`, which is of the scene, what a client gets that asks 30 times a second on the scene's path: the mask
  // of the camera at that time and the three before it.
  Result<void> see(gpu::SurfaceProbe& probe, double seconds, PictureSize size, SampleCounts samples);

  struct Shown {
    bool accumulated = false, filtered = false;
  };
  // Row by row, of the newest camera. Precondition: see() has succeeded.
  Result<std::vector<float>> of_light(uint32_t light, Shown shown);
  Result<std::vector<float>> of_ambient(Shown shown);

 private:
  Result<std::vector<float>> shares(gpu::ShadeOptions options, Shown shown);

  scenes::ScenePtr scene_;
  std::unique_ptr<gpu::ReferenceView> view_;
  gpu::CameraView camera_;
  gpu::SeenMasks alone_, accumulated_;
};

}  // namespace gnomon::bench
