#include "daemon/admin/readiness.h"

#include "daemon/scenes/scene_fetches.h"

namespace gnomon::daemon {
namespace {

// " (43%)" of a scene that is being read; else empty.
std::string share_of(const std::optional<SceneUnderWay>& scene) {
  const auto share = scene ? scene->share : std::nullopt;
  return share ? " (" + std::to_string(static_cast<int>(100 * *share)) + "%)" : "";
}

}  // namespace

std::string why_not_ready(const OperatedParts& parts) {
  const Health& health = parts.health;
  if (health.ready()) return "";
  std::string why;
  const auto add = [&](const std::string& reason) { why += (why.empty() ? "" : "; ") + reason; };
  if (health.stopping) add("stopping");
  if (health.draining) add("draining: nobody is admitted (gnomonctl undrain takes it back)");
  if (!health.device_up) add(health.scenes_loaded ? "no device is up" : "devices are being opened");
  if (!health.scenes_loaded) {
    const auto resident = parts.scenes.resident();
    const auto catalog = parts.catalog.get();
    std::string missing;
    for (const auto& source : catalog->sources()) {
      if (!resident.contains(source.name))
        missing += (missing.empty() ? "" : ", ") + source.name + share_of(under_way(parts.scenes, source.name));
    }
    add("scenes are being loaded: " + missing);
  }
  return why;
}

}  // namespace gnomon::daemon
