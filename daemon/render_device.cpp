#include "daemon/render_device.h"

namespace gnomon::daemon {

Result<std::unique_ptr<RenderDevice>> RenderDevice::open(RendererFactory factory) {
  auto renderer = factory();
  if (!renderer) return renderer.error();
  auto device = std::make_unique<RenderDevice>();
  device->factory_ = std::move(factory);
  device->renderer_ = std::move(*renderer);
  return device;
}

Result<gpu::SceneFootprint> RenderDevice::add_scene(const scenes::LoadedScene& scene) {
  if (auto made = renderer_->make_resident(scene.id, scene.scene); !made) return made.error();
  scenes_.emplace(scene.id, scene.scene);
  return renderer_->footprint(scene.id);
}

void RenderDevice::remove_scene(SceneId scene) {
  renderer_->evict(scene);
  scenes_.erase(scene);
}

Result<void> RenderDevice::rebuild(TimePoint now) {
  losses_.push_back(now);
  while (now - losses_.front() > kLossWindow) losses_.pop_front();
  if (losses_.size() > kMaxLosses) {
    return Error{"the device was lost " + std::to_string(losses_.size()) + " times within " +
                 std::to_string(kLossWindow.count()) + " s"};
  }
  renderer_.reset();  // first: two renderers may not fit on the device
  auto renderer = factory_();
  if (!renderer) return renderer.error();
  renderer_ = std::move(*renderer);
  for (const auto& [id, scene] : scenes_) {
    if (auto made = renderer_->make_resident(id, scene); !made) return made;
  }
  return {};
}

}  // namespace gnomon::daemon
