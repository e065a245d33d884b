// A device and what is resident on it, so that a lost one can be made anew.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>

#include "common/clock.h"
#include "common/result.h"
#include "gpu/renderer.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

using RendererFactory = std::function<Result<std::unique_ptr<gpu::Renderer>>()>;

// Losses within this time before we give up and leave the restart to the supervisor.
inline constexpr size_t kMaxLosses = 3;
inline constexpr std::chrono::seconds kLossWindow{60};

// The render thread's.
class RenderDevice {
 public:
  static Result<std::unique_ptr<RenderDevice>> open(RendererFactory factory);

  gpu::Renderer& renderer() const { return *renderer_; }

  // Blocking: uploads the scene and builds what the tracer needs.
  Result<gpu::SceneFootprint> add_scene(const scenes::LoadedScene& scene);

  void remove_scene(SceneId scene);  // precondition: nobody will submit a frame of it

  // A new renderer with the same scenes. Precondition: no lease of the old one is out.
  // Error: it failed, or the device was lost more than kMaxLosses times within kLossWindow.
  Result<void> rebuild(TimePoint now);

 private:
  RendererFactory factory_;
  std::unique_ptr<gpu::Renderer> renderer_;
  std::map<SceneId, scenes::ScenePtr> scenes_;
  std::deque<TimePoint> losses_;
};

}  // namespace gnomon::daemon
