// A device and what is resident on it, so that a lost one can be made anew.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "common/clock.h"
#include "common/result.h"
#include "daemon/render/render_inbox.h"
#include "gpu/renderer.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

using RendererFactory = std::function<Result<std::unique_ptr<gpu::Renderer>>()>;

// Losses within this time before we give up and leave the restart to the supervisor.
inline constexpr size_t kMaxLosses = 3;
inline constexpr std::chrono::seconds kLossWindow{60};

// Belongs to the render thread.
class RenderDevice {
 public:
  // `inbox` outlives the device and its leases. It gets BackgroundDone when finish_background has something to do, and
  // LeaseDropped when a slot is free again. `number`: among the daemon's devices.
  static Result<std::unique_ptr<RenderDevice>> open(RendererFactory factory, RenderInbox& inbox,
                                                    uint32_t number = 0);

  gpu::Renderer& renderer() const { return *renderer_; }
  uint32_t number() const { return number_; }
  // What the renderer is to call when finish_background has something to do. Any thread may call it.
  std::function<void()> wake() const {
    return [&inbox = *inbox_] { inbox.push(BackgroundDone{}); };
  }

  // Brings the scene to the device, beside the frames; `arrived` is called once, now or from finish_background. Callers
  // that ask for a scene on its way are answered together with the first. A scene that is on its way when the device is
  // lost is brought to the next renderer.
  using Arrived = std::function<void(Result<gpu::SceneFootprint>)>;
  void bring_scene(const scenes::LoadedScene& scene, Arrived arrived);
  // Answers all callers that still wait for a scene with the error.
  void refuse_arriving(const Error& why);

  void remove_scene(SceneId scene);  // precondition: nobody will submit a frame of it

  // A new renderer with the same scenes. Precondition: no lease of the old one is out.
  // Error: it failed, or the device was lost more than kMaxLosses times within kLossWindow.
  Result<void> rebuild(TimePoint now);

 private:
  struct Arriving {
    scenes::LoadedScene scene;
    std::vector<Arrived> waiting;
  };

  Result<void> make_renderer();
  void bring(SceneId id);
  void answer(SceneId id, const Result<gpu::SceneFootprint>& result);

  RendererFactory factory_;
  RenderInbox* inbox_ = nullptr;
  uint32_t number_ = 0;
  std::map<SceneId, scenes::ScenePtr> scenes_;
  std::map<SceneId, Arriving> arriving_;
  std::deque<TimePoint> losses_;
  std::unique_ptr<gpu::Renderer> renderer_;  // ends first: it refers to the rest
};

}  // namespace gnomon::daemon
