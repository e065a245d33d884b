#include "daemon/render/device_recovery.h"

#include <utility>

namespace gnomon::daemon {

void DeviceRecovery::lose() {
  if (!lost_) metrics_.devices().lost(device_.number());
  lost_ = true;
}

std::vector<RenderEvent> DeviceRecovery::recover(TimePoint now) {
  log::error("device lost: making it anew", {{"number", device_.number()}});
  if (auto rebuilt = device_.rebuild(now); !rebuilt) {
    failure_ = rebuilt.error();
    refuse_waiting(*failure_);
    return {};
  }
  lost_ = false;
  motion_.restore();
  log::info("device is back", {{"number", device_.number()}, {"device", device_.renderer().info().name}});
  return std::exchange(deferred_, {});
}

void DeviceRecovery::forget(SceneId scene) {
  std::erase_if(deferred_, [&](const RenderEvent& event) {
    const auto* arrived = std::get_if<SceneLoaded>(&event);
    return arrived && arrived->scene.id == scene;
  });
}

void DeviceRecovery::refuse_waiting(const Error& why) {
  device_.refuse_arriving(why);
  for (const RenderEvent& event : std::exchange(deferred_, {})) {
    if (const auto* arrived = std::get_if<SceneLoaded>(&event)) arrived->resident(why);
  }
}

}  // namespace gnomon::daemon
