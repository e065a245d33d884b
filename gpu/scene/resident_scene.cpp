#include "gpu/scene/resident_scene.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "gpu/scene/texels.h"

namespace gnomon::gpu {
namespace {

// The lights for which the tracer builds: lights that animations move are replaced by lights that reach nothing.
std::vector<exact::TracedLight> lights_to_build_for(const Tracer& tracer, const scenes::Scene& scene,
                                                    const std::vector<scenes::Light>& lights) {
  std::vector<exact::TracedLight> out;
  for (const scenes::Light& light : lights) {
    const bool moves = light.moved_by != scenes::kNone && tracer.builds_for_lights();
    out.push_back(moves ? silenced_light(scene.bounds) : traced_light(light, scene.bounds));
  }
  return out;
}

std::vector<exact::TracedLight> traced_lights(const scenes::Scene& scene,
                                              const std::vector<scenes::Light>& lights) {
  std::vector<exact::TracedLight> out;
  for (const scenes::Light& light : lights) out.push_back(traced_light(light, scene.bounds));
  return out;
}

// A structure that traces no light, for the frames until the tracer has built for a scene.
Result<TracedLights> traced_for_none(const Tracer& tracer, const scenes::Scene& scene) {
  TracedLights none{nullptr, {scene.lights.size(), silenced_light(scene.bounds)}};
  const scenes::WorldMesh no_mesh;
  const Buffer no_buffer;
  auto traced = tracer.build({scene, no_mesh, none.built_for, false, no_buffer, no_buffer});
  if (!traced) return traced.error();
  none.traced = std::move(*traced);
  return none;
}

void set_area_traced(PosedScene& posed, const AreaLights& areas) {
  posed.area_traced = areas.built().traced;
  if (!posed.area_traced) return;
  size_t built = 0;
  for (size_t i = 0; i < posed.lights.size(); ++i) {
    if (!areas.is_area(i)) continue;
    posed.area_built[i] =
        same_light(with_extent(posed.lights[i], posed.areas[i]), areas.built().built_for[built++]);
  }
}

// The area lights with their extents; those that animations move are replaced as in lights_to_build_for.
std::vector<exact::TracedLight> areas_to_build_for(const scenes::Scene& scene,
                                                   const std::vector<scenes::Light>& lights) {
  std::vector<exact::TracedLight> out;
  for (size_t i = 0; i < lights.size(); ++i) {
    if (scene.lights[i].area.shape == scenes::LightShape::point) continue;
    out.push_back(lights[i].moved_by != scenes::kNone
                      ? silenced_light(scene.bounds)
                      : with_extent(traced_light(lights[i], scene.bounds), lights[i].area));
  }
  return out;
}

Result<TracedLights> build(const Tracer& tracer, const scenes::Scene& scene, std::vector<exact::TracedLight> lights,
                           const std::vector<exact::TracedLight>& loaded, const BuildWatch& watch) {
  const scenes::GeometryPtr geometry = scenes::geometry_of(scene);
  TracedLights built{nullptr, std::move(lights)};
  const bool as_loaded =
      std::equal(loaded.begin(), loaded.end(), built.built_for.begin(), built.built_for.end(), same_light);
  const Buffer none;  // tracers that build for lights do so from the mesh
  auto traced = tracer.build({scene, geometry->mesh, built.built_for, as_loaded, none, none, watch});
  if (!traced) return traced.error();
  built.traced = std::move(*traced);
  return built;
}

}  // namespace

exact::TracedLight traced_light(const scenes::Light& light, const scenes::Bounds& bounds) {
  exact::TracedLight traced{};
  traced.position = light.position;
  traced.direction = light.direction;
  traced.outer_cone_cos = light.outer_cone_cos;
  traced.reach = light.range;
  switch (light.type) {
    case scenes::LightType::point: traced.kind = 0; break;
    case scenes::LightType::spot: traced.kind = 1; break;
    case scenes::LightType::directional:
      traced.kind = 2;
      traced.reach = 2.0f * glm::length(bounds.max - bounds.min);
      break;
  }
  return traced;
}

Result<std::unique_ptr<ResidentScene>> ResidentScene::create(const DevicePtr& device, const scenes::ScenePtr& scene,
                                                             const Tracer* tracer, uint32_t slots, Built built) {
  if (scene->lights.size() > kMaxLights)
    return Error{"scene '" + scene->name + "' has " + std::to_string(scene->lights.size()) + " lights; at most " +
                 std::to_string(kMaxLights) + " are supported"};
  auto resident = std::make_unique<ResidentScene>();
  resident->scene_ = scene;
  resident->lights_ = scene->lights;
  resident->area_lights_ = AreaLights(scene->lights);
  resident->moving_size_ = scenes::moving_mesh_size(*scene);
  resident->geometry_ = scenes::geometry_of(*scene);
  const scenes::WorldMesh& mesh = resident->geometry_->mesh;
  if (auto done = resident->upload_mesh(device, mesh, slots); !done) return done.error();
  if (auto done = resident->upload_clusters(device); !done) return done.error();
  if (auto done = resident->upload_materials(device, tracer == nullptr); !done) return done.error();
  if (!tracer) return resident;
  if (device->features().loads_texels())
    if (auto done = resident->upload_corners(device, mesh); !done) return done.error();
  if (auto done = resident->build_traced(*tracer, mesh, built); !done) return done.error();
  return resident;
}

Result<void> ResidentScene::build_traced(const Tracer& tracer, const scenes::WorldMesh& mesh, Built built) {
  built_for_lights_ = tracer.builds_for_lights();
  traced_.built_for = lights_to_build_for(tracer, *scene_, lights_);
  const TracerInput input{*scene_, mesh, traced_.built_for, true, buffers_.positions, buffers_.triangles};
  auto traced = built == Built::everything ? tracer.build(input) : tracer.build_at_once(input);
  if (!traced) return traced.error();
  traced_.traced = std::move(*traced);
  unbuilt_ = !traced_.traced;
  if (unbuilt_) {
    auto none = traced_for_none(tracer, *scene_);
    if (!none) return none.error();
    traced_ = std::move(*none);
  }
  if (tracer.is_hierarchy()) {
    static_bvh_ = traced_.traced;
    return {};
  }
  auto bvh = tracer.build_hierarchy(input);
  if (!bvh) return bvh.error();
  static_bvh_ = std::move(*bvh);
  return {};
}

Result<void> ResidentScene::set_lights(std::vector<scenes::Light> lights) {
  if (lights.size() != lights_.size()) return Error{"a scene keeps its number of lights"};
  for (size_t i = 0; i < lights.size(); ++i) lights[i].moved_by = lights_[i].moved_by;
  lights_ = std::move(lights);
  posed_.reset();
  return {};
}

void ResidentScene::give_traced(TracedLights traced, Shadows shadows) {
  posed_.reset();
  if (shadows == Shadows::soft) return area_lights_.give(std::move(traced));
  traced_ = std::move(traced);
  unbuilt_ = false;
}

LightState ResidentScene::light_state() const {
  LightState state;
  const std::vector<exact::TracedLight> lights = traced_lights(*scene_, lights_);
  for (size_t i = 0; i < lights.size(); ++i) {
    const bool animated = lights_[i].moved_by != scenes::kNone;
    const bool built = !built_for_lights_ || same_light(lights[i], traced_.built_for[i]);
    ++(animated || (!built && !unbuilt_) ? state.moving : built ? state.resting : state.unbuilt);
  }
  return state;
}

PosedScenePtr ResidentScene::pose(scenes::SceneTime time) const {
  if (posed_ && (posed_->time == time || !scenes::moves(*scene_))) return posed_;
  auto posed = std::make_shared<PosedScene>();
  posed->time = time;
  posed->mesh = scenes::build_moving_mesh(*scene_, time);
  if (traced_.traced) posed->bvh = moving_bvh_.follow(posed->mesh);
  posed->parts = parts_of(posed->bvh);
  posed->draws = draws_of(*scene_, posed->mesh);
  const std::vector<scenes::Light> lights = scenes::lights_at(*scene_, lights_, time);
  posed->lights = traced_lights(*scene_, lights);
  for (const scenes::Light& light : lights) posed->areas.push_back(light.area);
  posed->resting_lights = posed->lights;
  posed->traced = traced_.traced;
  if (built_for_lights_) {
    for (size_t i = 0; i < posed->lights.size(); ++i) {
      if (same_light(posed->lights[i], traced_.built_for[i])) continue;
      posed->moving_lights[i / 32] |= 1u << (i % 32);
      posed->resting_lights[i] = silenced_light(scene_->bounds);
    }
  }
  set_area_traced(*posed, area_lights_);
  posed->static_bvh = static_bvh_;
  posed_ = std::move(posed);
  return posed_;
}

Result<TracedLights> build_for_lights(const Tracer& tracer, const scenes::Scene& scene,
                                      const std::vector<scenes::Light>& lights, const BuildWatch& watch) {
  return build(tracer, scene, lights_to_build_for(tracer, scene, lights),
               lights_to_build_for(tracer, scene, scene.lights), watch);
}

Result<TracedLights> build_for_areas(const Tracer& tracer, const scenes::Scene& scene,
                                     const std::vector<scenes::Light>& lights, const BuildWatch& watch) {
  return build(tracer, scene, areas_to_build_for(scene, lights), areas_to_build_for(scene, scene.lights), watch);
}

Result<void> ResidentScene::upload_mesh(const DevicePtr& device, const scenes::WorldMesh& mesh, uint32_t slots) {
  vertex_count_ = static_cast<uint32_t>(mesh.positions.size());
  triangle_count_ = static_cast<uint32_t>(mesh.triangles.size());
  const VkBufferUsageFlags build =
      device->features().ray_query ? VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR : 0;
  const size_t vertices = size_t{slots} * moving_size_.vertices, triangles = size_t{slots} * moving_size_.triangles;
  const auto put = [&](Buffer& into, const auto& list, size_t room, VkBufferUsageFlags usage) -> Result<void> {
    std::remove_cvref_t<decltype(list)> grown;
    if (room > 0) {
      grown = list;
      grown.resize(list.size() + room);
    }
    auto buffer = upload(device, std::as_bytes(std::span(room > 0 ? grown : list)), usage);
    if (!buffer) return buffer.error();
    into = std::move(*buffer);
    return {};
  };
  if (auto r = put(buffers_.positions, mesh.positions, vertices, build); !r) return r;
  if (auto r = put(buffers_.normals, mesh.normals, vertices, 0); !r) return r;
  if (auto r = put(buffers_.uvs, mesh.uvs, vertices, 0); !r) return r;
  if (auto r = put(buffers_.triangles, mesh.triangles, triangles, build); !r) return r;
  return put(buffers_.triangle_materials, mesh.materials, triangles, 0);
}

Result<void> ResidentScene::upload_corners(const DevicePtr& device, const scenes::WorldMesh& mesh) {
  std::vector<glm::vec4> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles)
    for (const uint32_t corner : {t.x, t.y, t.z}) corners.emplace_back(mesh.positions[corner], 0.0f);
  auto uploaded = upload(device, std::as_bytes(std::span(corners)));
  if (!uploaded) return uploaded.error();
  buffers_.corners = std::move(*uploaded);
  auto texels = TexelSet::create(device, {{{buffers_.corners, VK_FORMAT_R32G32B32A32_UINT}}});
  if (!texels) return texels.error();
  texels_ = std::move(*texels);
  return {};
}

Result<void> ResidentScene::upload_clusters(const DevicePtr& device) {
  auto uploaded = upload(device, std::as_bytes(std::span(clusters().clusters)));
  if (!uploaded) return uploaded.error();
  buffers_.clusters = std::move(*uploaded);
  auto chunks = upload(device, std::as_bytes(std::span(clusters().chunks)));
  if (!chunks) return chunks.error();
  buffers_.cluster_chunks = std::move(*chunks);
  return {};
}

Result<void> ResidentScene::upload_materials(const DevicePtr& device, bool drawn) {
  std::vector<uint32_t> levels;
  for (const scenes::Texture& texture : scene_->textures) {
    if (texture.rgba.empty()) {  // only its file was kept: no alpha test reads it, and nobody draws it here
      levels.push_back(0);
      buffers_.textures.emplace_back();
      continue;
    }
    const Texels texels = drawn ? mipmapped_texels(texture) : flat_texels(texture);
    levels.push_back(texels.levels);
    auto buffer = upload(device, std::as_bytes(std::span(texels.rgba)));
    if (!buffer) return buffer.error();
    buffers_.textures.push_back(std::move(*buffer));
  }
  std::vector<MaterialRecord> records;
  for (const scenes::Material& material : scene_->materials) {
    MaterialRecord record;
    record.base_color = material.base_color;
    record.emissive = material.emissive;
    record.alpha_cutoff = material.alpha_cutoff;
    if (material.base_color_texture != scenes::kNone && levels[material.base_color_texture] > 0) {
      const scenes::Texture& texture = scene_->textures[material.base_color_texture];
      record.texels = buffers_.textures[material.base_color_texture].address();
      record.texture_width = texture.width;
      record.texture_height = texture.height;
      record.levels = levels[material.base_color_texture];
      record.wrap_u = static_cast<uint32_t>(texture.wrap_u);
      record.wrap_v = static_cast<uint32_t>(texture.wrap_v);
    }
    records.push_back(record);
  }
  auto buffer = upload(device, std::as_bytes(std::span(records)));
  if (!buffer) return buffer.error();
  buffers_.materials = std::move(*buffer);
  return {};
}

uint64_t ResidentScene::memory_bytes() const {
  uint64_t bytes = traced_.traced ? traced_.traced->memory_bytes() : 0;
  if (area_lights_.built().traced) bytes += area_lights_.built().traced->memory_bytes();
  if (static_bvh_ && static_bvh_ != traced_.traced) bytes += static_bvh_->memory_bytes();
  for (const Buffer* b :
       {&buffers_.positions, &buffers_.normals, &buffers_.uvs, &buffers_.triangles, &buffers_.triangle_materials,
        &buffers_.materials, &buffers_.clusters, &buffers_.cluster_chunks, &buffers_.corners})
    bytes += b->bytes();
  for (const Buffer& texture : buffers_.textures) bytes += texture.bytes();
  return bytes;
}

void ResidentScene::describe(FrameUniforms& frame, const PosedScene& posed) const {
  frame.scene = {buffers_.positions.address(),
                 buffers_.normals.address(),
                 buffers_.uvs.address(),
                 buffers_.triangles.address(),
                 buffers_.triangle_materials.address(),
                 buffers_.materials.address()};
  frame.light_count = light_count();
  frame.resting_triangles = triangle_count_;
  std::copy(posed.lights.begin(), posed.lights.end(), frame.lights);
}

}  // namespace gnomon::gpu
