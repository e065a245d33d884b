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

void LightBuilds::start(Owned owned, size_t lights, Work work, std::function<void()> wake) {
  stop(owned.scene);
  const Build& build = builds_[owned.scene] = {{}, std::make_shared<Shares>(lights)};
  const auto job = [this, work = std::move(work), stop = build.stop.get_token(), shares = build.shares] {
    const BuildWatch watch{[&](size_t light, double share) { shares->set(light, share); }, stop};
    const Background::Finish done = work(watch);
    return [this, shares, done] {
      std::erase_if(builds_, [&](const auto& other) { return other.second.shares == shares; });
      done();
    };
  };
  deferred_[owned.owner].push_back(
      [this, job, owner = owned.owner, wake = std::move(wake)] { threads_.run(owner, job, wake); });
  begin_deferred(owned.owner);
}

void LightBuilds::resume(SceneOwner owner) {
  if (--pauses_.at(owner) == 0) pauses_.erase(owner);
  begin_deferred(owner);
}

void LightBuilds::begin_deferred(SceneOwner owner) {
  if (pauses_.contains(owner)) return;
  const auto deferred = deferred_.extract(owner);
  if (deferred.empty()) return;
  for (const auto& begin : deferred.mapped()) begin();
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
