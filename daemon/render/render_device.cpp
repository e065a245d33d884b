#include "daemon/render/render_device.h"

#include "common/within_memory.h"

namespace gnomon::daemon {

Result<std::unique_ptr<RenderDevice>> RenderDevice::open(RendererFactory factory, RenderInbox& inbox,
                                                         uint32_t number) {
  auto device = std::make_unique<RenderDevice>();
  device->factory_ = std::move(factory);
  device->inbox_ = &inbox;
  device->number_ = number;
  if (auto made = device->make_renderer(); !made) return made.error();
  return device;
}

Result<void> RenderDevice::make_renderer() {
  auto made = factory_();
  if (!made) return made.error();
  renderer_ = std::move(*made);
  renderer_->on_slot_freed([&inbox = *inbox_] { inbox.push(SlotFreed{}); });
  return {};
}

void RenderDevice::bring_scene(const scenes::LoadedScene& scene, gpu::SceneOwner owner, Arrived arrived) {
  if (scenes_.contains(scene.id)) return arrived(renderer_->footprint(scene.id));
  const auto [arriving, is_new] = arriving_.try_emplace(scene.id, Arriving{scene, {}});
  const auto begun = within_memory([&, id = scene.id, new_scene = is_new]() -> Result<void> {
    arriving_.at(id).waiting.push_back(std::move(arrived));
    if (!new_scene) return {};
    owners_[id] = owner;
    bring(id);
    return {};
  });
  if (!begun && arriving_.contains(scene.id)) answer(scene.id, begun.error());
}

void RenderDevice::bring(SceneId id) {
  const auto resident = [this, id](const Result<void>& made) {
    if (!arriving_.contains(id)) return;  // refused meanwhile
    if (!made) return answer(id, made.error());
    const auto kept = within_memory([&]() -> Result<void> {
      scenes_.emplace(id, arriving_.at(id).scene.scene);
      return {};
    });
    answer(id, kept ? Result<gpu::SceneFootprint>(renderer_->footprint(id)) : kept.error());
  };
  renderer_->set_owner(id, owners_[id]);
  renderer_->bring(id, arriving_.at(id).scene.scene, resident, wake());
}

void RenderDevice::answer(SceneId id, const Result<gpu::SceneFootprint>& result) {
  const auto arriving = arriving_.extract(id);
  if (!result) owners_.erase(id);
  for (const Arrived& arrived : arriving.mapped().waiting) arrived(result);
}

void RenderDevice::refuse_arriving(const Error& why) {
  while (!arriving_.empty()) answer(arriving_.begin()->first, why);
}

void RenderDevice::remove_scene(SceneId scene) {
  renderer_->evict(scene);
  scenes_.erase(scene);
  owners_.erase(scene);
}

Result<void> RenderDevice::rebuild(TimePoint now) {
  losses_.push_back(now);
  while (now - losses_.front() > kLossWindow) losses_.pop_front();
  if (losses_.size() > kMaxLosses) {
    return Error{"the device was lost " + std::to_string(losses_.size()) + " times within " +
                 std::to_string(kLossWindow.count()) + " s"};
  }
  renderer_.reset();  // before the next one is made, as two renderers may not fit on the device
  if (auto made = make_renderer(); !made) return made;
  for (const auto& [id, scene] : scenes_) {
    renderer_->set_owner(id, owners_[id]);
    if (auto made = renderer_->make_resident(id, scene); !made) return made;
  }
  std::vector<SceneId> on_their_way;
  for (const auto& [id, arriving] : arriving_) on_their_way.push_back(id);
  for (const SceneId id : on_their_way) bring(id);
  return {};
}

}  // namespace gnomon::daemon
