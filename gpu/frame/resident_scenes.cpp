#include "gpu/frame/resident_scenes.h"

#include <utility>

#include "common/freed_memory.h"
#include "common/log.h"
#include "common/within_memory.h"
#include "scenes/light_samples.h"

namespace gnomon::gpu {

Error not_resident(SceneId id) { return Error{"scene " + std::to_string(id.value) + " is not resident"}; }

const ResidentScene* ResidentScenes::find(SceneId id) const {
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? nullptr : found->second.get();
}

Result<void> ResidentScenes::make_resident(SceneId id, const scenes::ScenePtr& scene) {
  if (scenes_.contains(id)) return {};
  auto resident = within_memory([&] {
    return ResidentScene::create(pool_->device(), scene, &pool_->tracer(), pool_->variants().slots(), built_);
  });
  if (!resident) return resident.error();
  scenes_[id] = std::move(*resident);
  give_back_freed_memory();
  return {};
}

// What is given to background_, light_builds_ and area_builds_ runs on a thread of theirs, and returns what the owner's
// thread calls in finish_background: here and below the outer function is the work, and the inner one takes over.
void ResidentScenes::bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
                           std::function<void()> wake) {
  const SceneOwner owner = owner_of(id);
  light_builds_.pause(owner);  // until the scene is resident, with at least a hierarchy for its lights
  area_builds_.pause(owner);
  background_.run(
      owner,
      [this, id, owner, scene, pool = pool_, built = built_, missing = missing_variants(false), resident] {
        const auto made = std::make_shared<Arrived>(arrive(*pool, scene, built, missing));
        return [this, id, owner, made, resident] {
          resident(settle_in(id, *made));
          light_builds_.resume(owner);
          area_builds_.resume(owner);
        };
      },
      std::move(wake));
  bring_occlusion(owner, scene);
}

SceneOwner ResidentScenes::owner_of(SceneId id) const {
  const auto found = owners_.find(id);
  return found == owners_.end() ? SceneOwner{} : found->second;
}

void ResidentScenes::evict(SceneId id) {
  owners_.erase(id);
  scenes_.erase(id);
  light_builds_.stop(id);
  area_builds_.stop(id);
  areas_asked_.erase(id);
}

Result<void> ResidentScenes::set_lights(SceneId id, std::vector<scenes::Light> lights) {
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? not_resident(id) : found->second->set_lights(std::move(lights));
}

void ResidentScenes::rebuild_lights(SceneId id, std::function<void(Result<void>)> settled,
                                    std::function<void()> wake) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return settled(not_resident(id));
  if (!pool_->tracer().builds_for_lights()) return settled({});
  light_builds_.start(
      {id, owner_of(id)}, found->second->light_count(),
      [this, id, scene = found->second->scene_ptr(), pool = pool_, lights = found->second->lights(),
       settled](const BuildWatch& watch) {
        const auto built = within_memory([&] { return build_for_lights(pool->tracer(), *scene, lights, watch); });
        return [this, id, scene, built, settled] {
          ResidentScene* resident = same_scene(id, scene);
          if (!resident) return settled(not_resident(id));
          if (!built) return settled(built.error());
          resident->give_traced(*built);
          areas_asked_.erase(id);  // the next soft frame has them built for these lights
          settled({});
        };
      },
      std::move(wake));
}

void ResidentScenes::build_areas(SceneId id) {
  area_builds_.finish();
  const ResidentScene& scene = *scenes_.at(id);
  const bool builds = pool_->tracer().soft_shader() && scene.area_lights().any();
  if (!builds || !light_builds_.progress(id).lights.empty() || !areas_asked_.insert(id).second) return;
  area_builds_.start(
      {id, owner_of(id)}, scene.area_lights().set().count(),
      [this, id, scene = scene.scene_ptr(), pool = pool_, lights = scene.lights()](const BuildWatch& watch) {
        const auto built = within_memory([&] { return build_for_areas(pool->tracer(), *scene, lights, watch); });
        return [this, id, scene, built] {
          ResidentScene* resident = same_scene(id, scene);
          if (!built) {
            log::warning("no light buffers for areas", {{"scene", scene->name}, {"reason", built.error().message}});
          } else if (resident) {
            resident->give_traced(*built, Shadows::soft);
          }
        };
      },
      [] {});  // the next soft frame takes it over
}

void ResidentScenes::finish_background() {
  background_.finish();
  light_builds_.finish();
}

std::vector<PlanKind> ResidentScenes::missing_variants(bool occlusion) const {
  std::vector<PlanKind> missing;
  for (const bool soft : {false, true})
    for (const bool motion : {false, true}) {
      const PlanKind kind{motion, soft, occlusion};
      if (!pool_->variants().has(kind)) missing.push_back(kind);
    }
  return missing;
}

// Any thread may call this.
ResidentScenes::Arrived ResidentScenes::arrive(const SlotPool& pool, const scenes::ScenePtr& scene, Built built,
                                               const std::vector<PlanKind>& missing) {
  Arrived made{within_memory([&] {
                 return ResidentScene::create(pool.device(), scene, &pool.tracer(), pool.variants().slots(), built);
               }),
               {}};
  if (!made.scene) return made;
  const bool moves = (*made.scene)->unbuilt() || scenes::moves(*scene);
  made.variants = make_variants(pool, missing, moves, (*made.scene)->area_lights().any());
  return made;
}

// Any thread may call this.
ResidentScenes::Variants ResidentScenes::make_variants(const SlotPool& pool, const std::vector<PlanKind>& missing,
                                                       bool moves, bool soft) {
  Variants made;
  for (const PlanKind kind : missing) {
    if ((kind.motion && !moves) || (kind.soft && !soft)) continue;
    // On an error, the first frame tries again and reports it.
    if (auto variant = pool.variants().make(kind)) made.emplace_back(kind, std::move(*variant));
  }
  return made;
}

void ResidentScenes::bring_occlusion(SceneOwner owner, const scenes::ScenePtr& scene) {
  background_.run(
      owner,
      [this, scene, pool = pool_, missing = missing_variants(true), built = built_] {
        // A scene without its light buffers is traced as one in motion is, by hierarchies, until they are built.
        const bool moves = built == Built::what_is_quick || scenes::moves(*scene);
        const auto made =
            std::make_shared<Variants>(make_variants(*pool, missing, moves, scenes::has_area_lights(*scene)));
        return [this, made] { give(*made); };
      },
      [] {});  // nobody waits for it: finish_background takes it over when something else calls it
}

void ResidentScenes::give(Variants& made) {
  for (auto& [kind, variant] : made) pool_->variants().give(kind, std::move(variant));
}

Result<void> ResidentScenes::settle_in(SceneId id, Arrived& made) {
  if (!made.scene) return made.scene.error();
  give(made.variants);
  scenes_[id] = std::move(*made.scene);
  return {};
}

// nullptr if the scene was evicted or replaced meanwhile.
ResidentScene* ResidentScenes::same_scene(SceneId id, const scenes::ScenePtr& scene) const {
  const auto found = scenes_.find(id);
  return found != scenes_.end() && found->second->scene_ptr() == scene ? found->second.get() : nullptr;
}

}  // namespace gnomon::gpu
