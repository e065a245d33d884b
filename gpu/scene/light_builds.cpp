#include "gpu/scene/light_builds.h"

#include <utility>

namespace gnomon::gpu {

void LightBuilds::Shares::set(size_t light, double share) {
  std::lock_guard lock(mutex_);
  if (light < shares_.size()) shares_[light] = static_cast<float>(share);
}

std::vector<float> LightBuilds::Shares::get() const {
  std::lock_guard lock(mutex_);
  return shares_;
}

LightBuilds::~LightBuilds() {
  for (auto& [scene, build] : builds_) build.stop.request_stop();
}

void LightBuilds::start(SceneId scene, size_t lights, Work work, std::function<void()> wake) {
  stop(scene);
  const Build& build = builds_[scene] = {{}, std::make_shared<Shares>(lights)};
  const auto job = [this, work = std::move(work), stop = build.stop.get_token(), shares = build.shares] {
    const BuildWatch watch{[&](size_t light, double share) { shares->set(light, share); }, stop};
    const Background::Finish done = work(watch);
    return [this, shares, done] {
      std::erase_if(builds_, [&](const auto& other) { return other.second.shares == shares; });
      done();
    };
  };
  deferred_.push_back([this, job, wake = std::move(wake)] { thread_.run(job, wake); });
  begin_deferred();
}

void LightBuilds::resume() {
  --pauses_;
  begin_deferred();
}

void LightBuilds::begin_deferred() {
  if (pauses_ > 0) return;
  for (const auto& begin : std::exchange(deferred_, {})) begin();
}

void LightBuilds::stop(SceneId scene) {
  const auto found = builds_.find(scene);
  if (found == builds_.end()) return;
  found->second.stop.request_stop();
  builds_.erase(found);
}

BuildProgress LightBuilds::progress(SceneId scene) const {
  const auto found = builds_.find(scene);
  return found == builds_.end() ? BuildProgress{} : BuildProgress{found->second.shares->get()};
}

}  // namespace gnomon::gpu
