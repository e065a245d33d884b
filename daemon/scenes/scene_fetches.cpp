#include "daemon/scenes/scene_fetches.h"

#include <algorithm>
#include <atomic>
#include <memory>

namespace gnomon::daemon {

std::future<Result<void>> fetch_later(SceneHost& host, const std::string& name) {
  struct Answer {
    std::promise<Result<void>> result;
    std::atomic<bool> given{false};
  };
  const auto answer = std::make_shared<Answer>();
  host.fetch(name, [answer](const Result<SceneForUse>& scene) {
    if (answer->given.exchange(true)) return;
    answer->result.set_value(scene ? Result<void>() : Result<void>(scene.error()));
  });
  return answer->result.get_future();
}

std::optional<SceneUnderWay> under_way(const SceneHost& host, const std::string& name) {
  const auto all = host.under_way();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const SceneUnderWay& scene) { return scene.name == name; });
  return found == all.end() ? std::nullopt : std::optional(*found);
}

}  // namespace gnomon::daemon
