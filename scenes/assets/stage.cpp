#include "scenes/assets/stage.h"

#include <algorithm>
#include <cmath>

namespace gnomon::scenes::assets {
namespace {

// The closed Catmull-Rom curve through `points` at parameter u in [0, points.size()).
glm::vec3 on_loop(const std::vector<glm::vec3>& points, float u) {
  const auto n = points.size();
  const auto i = static_cast<size_t>(u) % n;
  const float t = u - std::floor(u);
  const glm::vec3 a = points[(i + n - 1) % n], b = points[i], c = points[(i + 1) % n], d = points[(i + 2) % n];
  return 0.5f * (2.0f * b + (c - a) * t + (2.0f * a - 5.0f * b + 4.0f * c - d) * (t * t) +
                 (3.0f * b - a - 3.0f * c + d) * (t * t * t));
}

glm::quat looking(glm::vec3 from, glm::vec3 to) {
  const glm::vec3 back = glm::normalize(from - to);
  const glm::vec3 right = glm::normalize(glm::cross(glm::vec3(0, 1, 0), back));
  return glm::normalize(glm::quat_cast(glm::mat3(right, glm::cross(back, right), back)));
}

float to_linear(float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }

}  // namespace

Mesh& Model::in(uint32_t material) {
  for (Part& part : parts) {
    if (part.material == material) return part.mesh;
  }
  return parts.emplace_back(Part{material, {}}).mesh;
}

uint32_t Stage::add(Material material) {
  materials.push_back(std::move(material));
  return static_cast<uint32_t>(materials.size() - 1);
}

uint32_t Stage::add(Model model) {
  models.push_back(std::move(model));
  return static_cast<uint32_t>(models.size() - 1);
}

uint32_t Stage::matte(const std::string& material_name, glm::vec3 srgb) {
  Material material;
  material.name = material_name;
  material.base_color = linear(srgb);
  return add(std::move(material));
}

void Stage::dress(std::initializer_list<uint32_t> dressed, Pattern pattern, float metres) {
  auto found = made_.find(pattern);
  if (found == made_.end()) {
    ColourTexture texture = make_texture(pattern);
    found = made_.emplace(pattern, Made{static_cast<uint32_t>(images.size()), texture.mean}).first;
    images.push_back(std::move(texture.png));
  }
  for (const uint32_t material : dressed) {
    Material& m = materials[material];
    m.texture = found->second.image;
    m.texture_metres = metres;
    m.base_color /= found->second.mean;
    m.base_color /= std::max({m.base_color.r, m.base_color.g, m.base_color.b, 1.0f});  // glTF allows no more
  }
}

void Stage::place(uint32_t model, const glm::mat4& placement) { nodes.push_back({model, placement}); }
void Stage::place(Model model, const glm::mat4& placement) { place(add(std::move(model)), placement); }

uint64_t Stage::triangle_count() const {
  uint64_t count = 0;
  for (const Node& node : nodes) {
    for (const Part& part : models[node.model].parts) count += part.mesh.triangles.size();
  }
  return count;
}

glm::vec3 linear(glm::vec3 srgb) { return {to_linear(srgb.r), to_linear(srgb.g), to_linear(srgb.b)}; }

glm::vec3 linear(uint32_t rgb) {
  return linear(glm::vec3((rgb >> 16) & 255, (rgb >> 8) & 255, rgb & 255) / 255.0f);
}

std::vector<CameraKey> fly(const std::vector<glm::vec3>& eyes, const std::vector<glm::vec3>& targets,
                           float seconds) {
  constexpr int kStepsPerKnot = 64;
  constexpr float kKeysPerSecond = 30.0f;
  const auto knots = static_cast<int>(eyes.size());
  std::vector<float> travelled{0.0f};
  for (int i = 1; i <= knots * kStepsPerKnot; ++i) {
    const auto at_step = [&](int s) { return on_loop(eyes, static_cast<float>(s) / kStepsPerKnot); };
    travelled.push_back(travelled.back() + glm::distance(at_step(i - 1), at_step(i)));
  }

  std::vector<CameraKey> keys;
  const int count = static_cast<int>(std::lround(seconds * kKeysPerSecond));
  for (int k = 0; k <= count; ++k) {
    const float along = travelled.back() * static_cast<float>(k % count) / static_cast<float>(count);
    const auto next = std::upper_bound(travelled.begin(), travelled.end() - 1, along);
    const auto i = static_cast<size_t>(next - travelled.begin()) - 1;
    const float within = (along - travelled[i]) / std::max(travelled[i + 1] - travelled[i], 1e-6f);
    const float u = (static_cast<float>(i) + within) / kStepsPerKnot;
    CameraKey key{seconds * static_cast<float>(k) / static_cast<float>(count), on_loop(eyes, u), {}};
    key.orientation = looking(key.position, on_loop(targets, u));
    if (!keys.empty() && glm::dot(keys.back().orientation, key.orientation) < 0) key.orientation = -key.orientation;
    keys.push_back(key);
  }
  return keys;
}

}  // namespace gnomon::scenes::assets
