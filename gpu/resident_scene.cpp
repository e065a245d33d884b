#include "gpu/resident_scene.h"

#include <algorithm>

namespace gnomon::gpu {
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
                                                             const Tracer* tracer) {
  if (scene->lights.size() > kMaxLights)
    return Error{"scene '" + scene->name + "' has " + std::to_string(scene->lights.size()) + " lights; at most " +
                 std::to_string(kMaxLights) + " are supported"};
  auto resident = std::make_unique<ResidentScene>();
  resident->scene_ = scene;
  for (const scenes::Light& light : scene->lights) resident->lights_.push_back(traced_light(light, scene->bounds));
  scenes::WorldMesh mesh = scenes::build_world_mesh(*scene);
  resident->clusters_ = make_clusters(*scene, mesh);
  if (auto done = resident->upload_mesh(device, mesh); !done) return done.error();
  if (auto done = resident->upload_clusters(device); !done) return done.error();
  if (auto done = resident->upload_materials(device); !done) return done.error();
  if (!tracer) return resident;
  auto traced = tracer->build({*scene, mesh, resident->lights_, true, resident->positions_, resident->triangles_});
  if (!traced) return traced.error();
  resident->traced_ = std::move(*traced);
  return resident;
}

Result<void> ResidentScene::upload_mesh(const DevicePtr& device, const scenes::WorldMesh& mesh) {
  triangle_count_ = static_cast<uint32_t>(mesh.triangles.size());
  const VkBufferUsageFlags build =
      device->features().ray_query ? VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR : 0;
  const auto put = [&](Buffer& into, const auto& list, VkBufferUsageFlags usage) -> Result<void> {
    auto buffer = upload(device, std::as_bytes(std::span(list)), usage);
    if (!buffer) return buffer.error();
    into = std::move(*buffer);
    return {};
  };
  if (auto r = put(positions_, mesh.positions, build); !r) return r;
  if (auto r = put(normals_, mesh.normals, 0); !r) return r;
  if (auto r = put(uvs_, mesh.uvs, 0); !r) return r;
  if (auto r = put(triangles_, mesh.triangles, build); !r) return r;
  return put(triangle_materials_, mesh.materials, 0);
}

Result<void> ResidentScene::upload_clusters(const DevicePtr& device) {
  auto clusters = upload(device, std::as_bytes(std::span(clusters_.clusters)));
  if (!clusters) return clusters.error();
  cluster_buffer_ = std::move(*clusters);
  auto chunks = upload(device, std::as_bytes(std::span(clusters_.chunks)));
  if (!chunks) return chunks.error();
  chunk_buffer_ = std::move(*chunks);
  return {};
}

Result<void> ResidentScene::upload_materials(const DevicePtr& device) {
  for (const scenes::Texture& texture : scene_->textures) {
    auto buffer = upload(device, std::as_bytes(std::span(texture.rgba)));
    if (!buffer) return buffer.error();
    textures_.push_back(std::move(*buffer));
  }
  std::vector<MaterialRecord> records;
  for (const scenes::Material& material : scene_->materials) {
    MaterialRecord record;
    record.base_color = material.base_color;
    record.emissive = material.emissive;
    record.alpha_cutoff = material.alpha_cutoff;
    if (material.base_color_texture != scenes::kNone) {
      const scenes::Texture& texture = scene_->textures[material.base_color_texture];
      record.texels = textures_[material.base_color_texture].address();
      record.texture_width = texture.width;
      record.texture_height = texture.height;
      record.wrap_u = static_cast<uint32_t>(texture.wrap_u);
      record.wrap_v = static_cast<uint32_t>(texture.wrap_v);
    }
    records.push_back(record);
  }
  auto buffer = upload(device, std::as_bytes(std::span(records)));
  if (!buffer) return buffer.error();
  materials_ = std::move(*buffer);
  return {};
}

uint64_t ResidentScene::memory_bytes() const {
  uint64_t bytes = traced_ ? traced_->memory_bytes() : 0;
  for (const Buffer* b : {&positions_, &normals_, &uvs_, &triangles_, &triangle_materials_, &materials_,
                          &cluster_buffer_, &chunk_buffer_})
    bytes += b->bytes();
  for (const Buffer& texture : textures_) bytes += texture.bytes();
  return bytes;
}

void ResidentScene::describe(FrameUniforms& frame) const {
  frame.scene = {positions_.address(),          normals_.address(),  uvs_.address(), triangles_.address(),
                 triangle_materials_.address(), materials_.address()};
  frame.light_count = light_count();
  std::copy(lights_.begin(), lights_.end(), frame.lights);
}

}  // namespace gnomon::gpu
