// The scenes on a device: makes them resident, changes their lights and evicts them. Long work runs on threads of its
// own, beside the frames.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "gpu/frame/slot_pool.h"
#include "gpu/scene/background.h"
#include "gpu/scene/light_builds.h"

namespace gnomon::gpu {

// All calls: the render loop's thread. The contracts are those of Renderer.
class ResidentScenes {
 public:
  // `built`: what a scene waits for before it is resident.
  ResidentScenes(std::shared_ptr<SlotPool> pool, Built built) : pool_(std::move(pool)), built_(built) {}

  // nullptr if the scene is not resident.
  const ResidentScene* find(SceneId id) const;

  Result<void> make_resident(SceneId id, const scenes::ScenePtr& scene);
  void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
             std::function<void()> wake);
  void set_owner(SceneId id, SceneOwner owner) { owners_[id] = owner; }
  // Precondition: all recorded submits of the scene were started.
  void evict(SceneId id);

  Result<void> set_lights(SceneId id, std::vector<scenes::Light> lights);
  void rebuild_lights(SceneId id, std::function<void(Result<void>)> settled, std::function<void()> wake);
  // Before a soft frame of the scene: takes over what was built for the extents of area lights, and has it built beside
  // the frames if it was not yet. Until then, hierarchies trace them. Precondition: the scene is resident.
  void build_areas(SceneId id);
  BuildProgress build_progress(SceneId id) const { return light_builds_.progress(id); }
  void finish_background();

 private:
  // As many as the daemon has readers, so that no scene waits for one of somebody else's that takes long.
  static constexpr uint32_t kScenesAtOnce = 4;

  using Variants = std::vector<std::pair<PlanKind, std::unique_ptr<PlanVariant>>>;
  // A scene made beside the frames, and the variants that the scene is the first to need.
  struct Arrived {
    Result<std::unique_ptr<ResidentScene>> scene;
    Variants variants;
  };

  // `missing`: the kinds of variants that there are none of.
  static Arrived arrive(const SlotPool& pool, const scenes::ScenePtr& scene, Built built,
                        const std::vector<PlanKind>& missing);
  static Variants make_variants(const SlotPool& pool, const std::vector<PlanKind>& missing, bool moves, bool soft);
  // Those that the scene may need for ambient occlusion, which it does not wait for.
  void bring_occlusion(SceneOwner owner, const scenes::ScenePtr& scene);
  SceneOwner owner_of(SceneId id) const;
  std::vector<PlanKind> missing_variants(bool occlusion) const;
  void give(Variants& made);
  Result<void> settle_in(SceneId id, Arrived& made);
  ResidentScene* same_scene(SceneId id, const scenes::ScenePtr& scene) const;

  const std::shared_ptr<SlotPool> pool_;
  const Built built_;
  std::map<SceneId, std::unique_ptr<ResidentScene>> scenes_;
  std::map<SceneId, SceneOwner> owners_;  // others are nobody's in particular
  Background background_{kScenesAtOnce,
                         SceneOwner{}};  // declared last, so that its threads and those of the builds end first
  LightBuilds light_builds_;
  std::set<SceneId> areas_asked_;  // scenes whose areas are built, or being built, or could not be
  LightBuilds area_builds_;
};

Error not_resident(SceneId id);

}  // namespace gnomon::gpu
