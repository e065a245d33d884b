#include "tests/bench/growth_scene.h"

#include <algorithm>
#include <cmath>

#include "scenes/assets/shapes.h"

namespace gnomon::bench {
namespace {

namespace assets = scenes::assets;

constexpr float kHalf = 10.0f;   // of the floor's side, metres
constexpr float kHeight = 6.0f;  // of the walls
constexpr float kVessel = 1.5f;  // as tall as modelled
constexpr uint32_t kHall = 0, kClay = 1;

scenes::Primitive primitive(const assets::Mesh& mesh, uint32_t material) {
  scenes::Primitive out;
  out.material = material;
  out.positions = mesh.positions;
  out.normals = mesh.normals;
  out.triangles = mesh.triangles;
  return out;
}

// A floor and two walls, open towards +X and +Z.
assets::Mesh hall() {
  assets::Mesh mesh;
  for (const auto& [low, high] : {std::pair{glm::vec3(-kHalf, -0.2f, -kHalf), glm::vec3(kHalf, 0, kHalf)},
                                  {glm::vec3(-kHalf - 0.2f, 0, -kHalf), glm::vec3(-kHalf, kHeight, kHalf)},
                                  {glm::vec3(-kHalf, 0, -kHalf - 0.2f), glm::vec3(kHalf, kHeight, -kHalf)}})
    assets::append(mesh, assets::bevel_box(low, high, 0.0f));
  return mesh;
}

assets::Mesh vessel() {
  return assets::turned_vessel({{0, 0},
                                {0.3f, 0},
                                {0.34f, 0.06f},
                                {0.2f, 0.2f},
                                {0.32f, 0.6f},
                                {0.42f, 1.0f},
                                {0.2f, 1.35f},
                                {0.26f, kVessel},
                                {0, kVessel}},
                               20, 2);
}

// On the floor, row by row.
glm::mat4 placement(uint32_t index, uint32_t side) {
  const float cell = 2 * kHalf / static_cast<float>(side);
  const auto middle = [&](uint32_t i) { return (static_cast<float>(i) + 0.5f) * cell - kHalf; };
  return assets::at(middle(index % side), 0, middle(index / side)) * assets::scaled(std::min(1.0f, cell));
}

// The i-th number of the van der Corput sequence, whose first n numbers are evenly spread for every n.
float spread(uint32_t i, uint32_t base) {
  float value = 0, digit = 1;
  for (; i > 0; i /= base) value += static_cast<float>(i % base) * (digit /= static_cast<float>(base));
  return value;
}

scenes::Light lamp(uint32_t i) {
  scenes::Light light;
  light.position = {1.6f * kHalf * (spread(i + 1, 2) - 0.5f), 3.0f + 2.5f * spread(i + 1, 5),
                    1.6f * kHalf * (spread(i + 1, 3) - 0.5f)};
  light.intensity = 40.0f;
  return light;
}

}  // namespace

scenes::ScenePtr growth_scene(uint64_t triangles, uint32_t lights) {
  auto scene = std::make_shared<scenes::Scene>();
  scene->name = "hall";
  scene->materials.resize(2);
  scene->meshes = {{"hall", {primitive(hall(), kHall)}}, {"vessel", {primitive(vessel(), kClay)}}};
  const uint64_t of_hall = scene->meshes[0].primitives[0].triangles.size();
  const uint64_t of_vessel = scene->meshes[1].primitives[0].triangles.size();
  const uint64_t most = triangles > of_hall ? (triangles - of_hall) / of_vessel : 0;
  const auto vessels = static_cast<uint32_t>(std::max<uint64_t>(1, most));
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(vessels))));
  scene->instances.push_back({0});
  for (uint32_t i = 0; i < vessels; ++i) scene->instances.push_back({1, placement(i, side)});
  scene->triangle_count = of_hall + vessels * of_vessel;
  for (uint32_t i = 0; i < lights; ++i) scene->lights.push_back(lamp(i));
  scene->cameras.resize(1);
  scene->bounds = {{-kHalf - 0.2f, -0.2f, -kHalf - 0.2f}, {kHalf, kHeight, kHalf}};
  return scene;
}

}  // namespace gnomon::bench
