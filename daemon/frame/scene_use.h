// The use of a resident scene by a session.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

namespace gnomon::daemon {

// How many uses of one scene there are. Any thread.
using SceneUses = std::atomic<uint32_t>;

// A scene is not unloaded while a use of it exists. Move-only; any thread may drop it, also after the scene's host.
class SceneUse {
 public:
  SceneUse() = default;  // uses no scene
  explicit SceneUse(std::shared_ptr<SceneUses> uses) : uses_(std::move(uses)) { ++*uses_; }
  SceneUse(SceneUse&& other) noexcept = default;
  SceneUse& operator=(SceneUse&& other) noexcept {
    std::swap(uses_, other.uses_);
    return *this;
  }
  ~SceneUse() {
    if (uses_) --*uses_;
  }

 private:
  std::shared_ptr<SceneUses> uses_;
};

}  // namespace gnomon::daemon
