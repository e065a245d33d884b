#include "daemon/scenes/scene_fetches.h"

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

}  // namespace gnomon::daemon
