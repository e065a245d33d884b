#include "scenes/content_hash.h"

#include <xxhash.h>

#include <cstring>
#include <limits>
#include <memory>
#include <unordered_map>

#include "scenes/motion.h"
#include "scenes/world_triangles.h"

namespace gnomon::scenes {
namespace {

// To be increased whenever the hash covers something else, so that old caches are not mistaken for current ones.
constexpr uint32_t kVersion = 3;

class Hasher {
 public:
  Hasher() : state_(XXH3_createState(), &XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

  void add_bytes(const void* data, size_t size) { XXH3_128bits_update(state_.get(), data, size); }

  template <class... T>
  void add(const T&... values) {
    (add_one(values), ...);
  }

  ContentHash finish() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    ContentHash hash;
    static_assert(sizeof canonical.digest == sizeof(ContentHash));
    std::memcpy(hash.data(), canonical.digest, hash.size());
    return hash;
  }

 private:
  template <class T>
  void add_one(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T> ||
                  std::is_same_v<T, glm::vec2> || std::is_same_v<T, glm::vec3>);
    add_bytes(&value, sizeof value);
  }

  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

ContentHash hash_of_alphas(const Texture& texture) {
  std::vector<uint8_t> alphas(texture.rgba.size() / 4);
  for (size_t i = 0; i < alphas.size(); ++i) alphas[i] = texture.rgba[4 * i + 3];
  Hasher hasher;
  hasher.add_bytes(alphas.data(), alphas.size());
  return hasher.finish();
}

void add_lights(const Scene& scene, Hasher& hasher) {
  hasher.add(static_cast<uint64_t>(scene.lights.size()));
  for (const Light& light : scene.lights) {
    hasher.add(light.type);
    if (light.type != LightType::directional) hasher.add(light.position, light.range);
    if (light.type != LightType::point) hasher.add(light.direction);
    if (light.type == LightType::spot) hasher.add(light.outer_cone_cos);
  }
}

class Walk {
 public:
  explicit Walk(const Scene& scene) : scene_(scene) { hasher_.add(kVersion); }

  void opaque_triangles(std::span<const Instance> instances) {
    for_each_placement(scene_, instances, Blocking::always, [&](const Placement& p) { triangles(p, false); });
    hasher_.add(count_);
  }

  void tested_triangles(std::span<const Instance> instances) {
    for_each_placement(scene_, instances, Blocking::by_alpha, [&](const Placement& p) {
      const uint32_t material = p.primitive.material;
      if (material != last_tested_) add_alpha_test(material);
      last_tested_ = material;
      triangles(p, true);
    });
    hasher_.add(count_);
  }

  // Adds nothing for a scene at rest.
  void motion() {
    if (scene_.moving_nodes.empty()) return;
    const std::vector<Instance> moved = moved_instances(scene_, SceneTime(0));
    opaque_triangles(moved);
    tested_triangles(moved);
    for (const Instance& instance : scene_.instances) hasher_.add(instance.moved_by);
    for (const Light& light : scene_.lights) hasher_.add(light.moved_by);
    for (const MovingNode& node : scene_.moving_nodes) add_node(node);
    grow(moved_bounds(scene_, bounds_));
  }

  Extent finish() {
    add_lights(scene_, hasher_);
    return {hasher_.finish(), count_ == 0 ? Bounds{} : bounds_};
  }

 private:
  // Materials may alternate from one placement to the next, so that a texture is read once and not each time.
  void add_alpha_test(uint32_t material) {
    const Material& m = scene_.materials[material];
    const Texture& t = scene_.textures[m.base_color_texture];
    hasher_.add(m.base_color.a, m.alpha_cutoff, t.width, t.height, t.wrap_u, t.wrap_v);
    const auto [alphas, is_new] = alphas_.try_emplace(m.base_color_texture);
    if (is_new) alphas->second = hash_of_alphas(t);
    hasher_.add_bytes(alphas->second.data(), alphas->second.size());
  }

  void triangles(const Placement& placement, bool with_uvs) {
    const Primitive& primitive = placement.primitive;
    const std::vector<glm::vec3> positions = placement.world_positions();
    const bool mirrored = placement.mirrored();
    const bool double_sided = scene_.materials[primitive.material].double_sided;
    for (const glm::uvec3& triangle : primitive.triangles) {
      const glm::uvec3 t = wound(triangle, mirrored);
      const glm::vec3 corners[3] = {positions[t.x], positions[t.y], positions[t.z]};
      if (!has_area(face_normal(corners[0], corners[1], corners[2]))) continue;
      if (double_sided != double_sided_) hasher_.add(count_);  // the triangle at which it changes
      double_sided_ = double_sided;
      for (const glm::vec3& p : corners) grow({p, p});
      hasher_.add_bytes(corners, sizeof corners);
      if (with_uvs && !primitive.uvs.empty()) {
        hasher_.add(primitive.uvs[t.x], primitive.uvs[t.y], primitive.uvs[t.z]);
      }
      ++count_;
    }
  }

  void add_node(const MovingNode& node) {
    hasher_.add(node.parent, node.local.translation, node.local.scale, node.local.has_matrix);
    for (int c = 0; c < 4; ++c) {
      hasher_.add(node.local.rotation[c], glm::vec3(node.local.matrix[c]));
      for (int row = 0; row < 4; ++row) hasher_.add(node.parent_to_world[c][row]);
    }
    for (const Channel& channel : node.channels) {
      hasher_.add(channel.path, channel.interpolation, static_cast<uint64_t>(channel.times.size()));
      hasher_.add_bytes(channel.times.data(), channel.times.size() * sizeof(float));
      hasher_.add_bytes(channel.values.data(), channel.values.size() * sizeof(glm::vec4));
    }
  }

  void grow(const Bounds& more) {
    bounds_.min = glm::min(bounds_.min, more.min);
    bounds_.max = glm::max(bounds_.max, more.max);
  }

  const Scene& scene_;
  Hasher hasher_;
  std::unordered_map<uint32_t, ContentHash> alphas_;  // by texture
  Bounds bounds_{glm::vec3(std::numeric_limits<float>::max()), glm::vec3(std::numeric_limits<float>::lowest())};
  uint64_t count_ = 0;
  uint32_t last_tested_ = kNone;
  bool double_sided_ = false;
};

}  // namespace

Extent measure(const Scene& scene) {
  Walk walk(scene);
  walk.opaque_triangles(scene.instances);
  walk.tested_triangles(scene.instances);
  walk.motion();
  return walk.finish();
}

}  // namespace gnomon::scenes
