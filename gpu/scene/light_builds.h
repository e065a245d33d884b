// What a tracer builds for the lights of scenes beside the frames: one scene after the other, with little of the
// processor, so that frames come first.
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

// The owner's thread.
class LightBuilds {
 public:
  // Done on the building thread; returns what remains to be done on the owner's.
  using Work = std::function<Background::Finish(const BuildWatch&)>;

  ~LightBuilds();  // ends the build under way, and waits for that

  // In the place of an earlier build for the same scene, whose result still comes.
  void start(SceneId scene, size_t lights, Work work, std::function<void()> wake);
  // Between these two nothing new is begun: something more urgent needs the processor. They nest.
  void hold() { ++holds_; }
  void release();
  void stop(SceneId scene);  // its result still comes, soon: an error, if the build was not done
  void finish() { thread_.finish(); }

  // None: nothing is being built for the scene, nor waits for its turn.
  BuildProgress progress(SceneId scene) const;

 private:
  void begin_held();

  // Of each light, the share that is done. Any thread.
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

  // Beside a thread that has work for all of a core, a thread of this niceness gets about a quarter of it: frames cost
  // several times less once the build is done.
  static constexpr int kNiceness = 5;

  std::map<SceneId, Build> builds_;
  int holds_ = 0;
  std::vector<std::function<void()>> held_;  // what is begun at the last release
  Background thread_{kNiceness};             // ends first
};

}  // namespace gnomon::gpu
