// A device and the list of what is resident on it, so that it can be rebuilt after a loss.
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

// More than kMaxLosses losses within kLossWindow, and the device is given up.
inline constexpr size_t kMaxLosses = 3;
inline constexpr std::chrono::seconds kLossWindow{60};

// Belongs to the render thread.
class RenderDevice {
 public:
  // `inbox` outlives the device and its leases. It receives BackgroundDone when Renderer::finish_background has
  // something to do, and SlotFreed when a slot is free again. `number`: among the daemon's devices.
  static Result<std::unique_ptr<RenderDevice>> open(RendererFactory factory, RenderInbox& inbox,
                                                    uint32_t number = 0);

  gpu::Renderer& renderer() const { return *renderer_; }
  uint32_t number() const { return number_; }
  // For the renderer, to call when finish_background has something to do. Any thread may call it.
  std::function<void()> wake() const {
    return [&inbox = *inbox_] { inbox.push(BackgroundDone{}); };
  }

  // Brings the scene to the device in the background; `arrived` is called once, during the call or from
  // finish_background. Callers that ask for a scene on its way are answered together with the first. A scene that is on
  // its way when the device is lost is brought to the next renderer.
  using Arrived = std::function<void(Result<gpu::SceneFootprint>)>;
  void bring_scene(const scenes::LoadedScene& scene, gpu::SceneOwner owner, Arrived arrived);
  // Answers all callers that still wait for a scene with the error.
  void refuse_arriving(const Error& why);

  void remove_scene(SceneId scene);  // precondition: no frame of it will be submitted

  // Makes a new renderer with the same scenes; blocking. Precondition: no lease of the old one is out.
  // Error if that fails, or if the device was lost more than kMaxLosses times within kLossWindow.
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
  std::map<SceneId, gpu::SceneOwner> owners_;  // of those and of arriving_
  std::map<SceneId, Arriving> arriving_;
  std::deque<TimePoint> losses_;
  std::unique_ptr<gpu::Renderer> renderer_;  // destroyed first, as its callbacks refer to the other members
};

}  // namespace gnomon::daemon
