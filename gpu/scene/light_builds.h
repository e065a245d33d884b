// A tracer's builds for the lights of scenes, beside the frames: one scene of an owner after the other, at low CPU
// priority, so that frames come first.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "gpu/renderer.h"
#include "gpu/scene/background.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {

// All calls: the owner's thread.
class LightBuilds {
 public:
  // Called on the building thread; returns what finish() calls on the owner's thread.
  using Work = std::function<Background::Finish(const BuildWatch&)>;

  ~LightBuilds();  // stops the build in progress, and waits for its end

  // A scene with its owner.
  struct Owned {
    SceneId scene;
    SceneOwner owner{};
  };
  // Starts a build, and stops an earlier one of the same scene, whose result is still delivered. `lights`: the number
  // of lights that the build reports progress for.
  void start(Owned scene, size_t lights, Work work, std::function<void()> wake);
  // Between pause() and resume() no build of the owner is started, because more urgent work of its own needs the CPU.
  // Calls nest.
  void pause(SceneOwner owner) { ++pauses_[owner]; }
  void resume(SceneOwner owner);
  // Stops the scene's build. Its result is still delivered soon; it is an error if the build was not done.
  void stop(SceneId scene);
  void finish() { threads_.finish(); }

  // No lights if the scene has no build, neither in progress nor waiting.
  BuildProgress progress(SceneId scene) const;

 private:
  void begin_deferred(SceneOwner owner);

  // The share of the work that is done, for each light. Any thread.
  class Shares {
   public:
    explicit Shares(size_t lights) : shares_(lights) {}
    void set(size_t light, double share);
    std::vector<float> get() const;

   private:
    mutable std::mutex mutex_;
    std::vector<float> shares_;
  };
  struct Build {
    std::stop_source stop;
    std::shared_ptr<Shares> shares;
  };

  // A thread of this niceness gets about a quarter of a core that a busy thread shares. Less would delay the end of the
  // build, after which frames cost several times less.
  static constexpr int kNiceness = 5;
  static constexpr uint32_t kOwnersAtOnce = 2;  // so that a scene of one that takes minutes holds up no other's

  std::map<SceneId, Build> builds_;
  std::map<SceneOwner, int> pauses_;
  std::map<SceneOwner, std::vector<std::function<void()>>> deferred_;  // builds that the last resume() starts
  Background threads_{kOwnersAtOnce, kNiceness};                       // declared last, so that it ends first
};

}  // namespace gnomon::gpu
