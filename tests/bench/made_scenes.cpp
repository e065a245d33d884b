#include "tests/bench/made_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"

namespace gnomon::bench {
namespace {

namespace assets = scenes::assets;
using assets::Random;

constexpr float kHalf = 8.0f;  // of the floor's side, metres
constexpr uint32_t kBladeSegments = 2;

struct Made {
  assets::Mesh mesh;
  std::vector<glm::vec3> lamps;
};

glm::vec3 direction(Random& random) {
  for (;;) {
    const glm::vec3 d(random.range(-1, 1), random.range(-1, 1), random.range(-1, 1));
    if (const float length = glm::length(d); length > 0.1f && length < 1.0f) return d / length;
  }
}

assets::Mesh floor() {
  return assets::surface(
      16, 16, [](float u, float v) { return glm::vec3((2 * v - 1) * kHalf, 0.0f, (2 * u - 1) * kHalf); });
}

void add_triangle(assets::Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.normals.insert(mesh.normals.end(), {normal, normal, normal});
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

// A blade bends over towards `lean` and ends in a point: three triangles.
void add_blade(assets::Mesh& mesh, glm::vec3 root, glm::vec3 lean, float height, float width) {
  const glm::vec3 across = 0.5f * width * glm::normalize(glm::cross(lean, glm::vec3(0, 1, 0)));
  std::array<glm::vec3, 2> side{root - across, root + across};
  for (uint32_t s = 1; s <= kBladeSegments; ++s) {
    const float t = static_cast<float>(s) / (kBladeSegments + 1), up = height * t;
    const glm::vec3 middle = root + glm::vec3(0, up, 0) + lean * (0.5f * height * t * t);
    const std::array<glm::vec3, 2> next{middle - across * (1 - t), middle + across * (1 - t)};
    if (s == kBladeSegments) {
      add_triangle(mesh, side[0], side[1], middle);
    } else {
      add_triangle(mesh, side[0], side[1], next[1]);
      add_triangle(mesh, side[0], next[1], next[0]);
    }
    side = next;
  }
}

Made meadow() {
  Made made{floor(), {{-4, 0.9f, -3}, {3, 0.6f, 4}, {5, 2.5f, -5}, {-3, 1.4f, 5}}};
  Random random(1);
  for (int blade = 0; blade < 333'000; ++blade) {
    const float turn = random.range(0, 6.283f);
    add_blade(made.mesh, {random.range(-kHalf, kHalf), 0, random.range(-kHalf, kHalf)},
              {std::cos(turn), 0, std::sin(turn)}, random.range(0.1f, 0.35f), random.range(0.004f, 0.01f));
  }
  return made;
}

Made bush() {
  Made made{floor(), {{0, 2, 0}, {0.7f, 2.5f, -0.4f}, {4, 3, 4}, {-6, 1, 2}}};
  Random random(2);
  for (int leaf = 0; leaf < 200'000; ++leaf) {
    const glm::vec3 at = glm::vec3(0, 2, 0) + direction(random) * (1.8f * std::cbrt(random.unit()));
    const glm::vec3 along = direction(random) * random.range(0.02f, 0.08f);
    const glm::vec3 across = glm::normalize(glm::cross(along, direction(random))) * random.range(0.01f, 0.03f);
    add_triangle(made.mesh, at - across, at + across, at + along);
  }
  return made;
}

Made clutter() {
  Made made{floor(), {{-4, 3, -4}, {4, 3, 4}, {0, 1.2f, 0}, {5, 0.8f, -3}}};
  Random random(3);
  for (int thing = 0; thing < 1'500; ++thing) {
    const float radius = random.range(0.05f, 0.35f);
    const glm::vec3 at(random.range(-kHalf, kHalf) * 0.8f, random.range(0, 1.2f),
                       random.range(-kHalf, kHalf) * 0.8f);
    assets::append(made.mesh, assets::sphere(radius, 20), assets::at(at));
  }
  return made;
}

Made bars() {
  Made made{floor(), {{0, 3, 0}, {-4, 1, 2}, {4, 2, -4}, {5, 4, 5}}};
  Random random(4);
  for (int bar = 0; bar < 3'000; ++bar) {
    const glm::vec3 middle(random.range(-kHalf, kHalf), random.range(0.2f, 5), random.range(-kHalf, kHalf));
    const glm::vec3 half = direction(random) * random.range(0.5f, 6.0f);
    assets::append(made.mesh, assets::tube({middle - half, middle + half}, random.range(0.005f, 0.03f), 8));
  }
  return made;
}

Made sheets() {
  Made made{floor(), {{-6, 2, 0}, {6, 2, 0.01f}, {0, 4, -6}, {0.02f, 1, 6}}};
  Random random(5);
  for (int sheet = 0; sheet < 240; ++sheet) {
    const float x = random.range(-kHalf, kHalf), tilt = random.range(-0.02f, 0.02f);
    const float low = random.range(0.1f, 2.0f), high = low + random.range(0.3f, 2.5f);
    const float z = random.range(-kHalf, kHalf), length = random.range(0.5f, 4.0f);
    assets::append(made.mesh, assets::surface(40, 12, [&](float u, float v) {
                     const float wave = 0.03f * std::sin(20 * u + x);
                     return glm::vec3(x + tilt * u + wave, low + (high - low) * v, z + length * (u - 0.5f));
                   }));
  }
  return made;
}

Made hills() {
  const auto height = [](float x, float z) {
    float sum = 0, size = 1.0f;
    for (float wave = 0.5f; wave < 40; wave *= 2.1f, size *= 0.48f)
      sum += size * std::sin(wave * x + 1.7f * size) * std::cos(wave * z - 0.9f * size);
    return sum;
  };
  Made made;
  made.mesh = assets::surface(600, 600, [&](float u, float v) {
    const float x = (2 * v - 1) * kHalf, z = (2 * u - 1) * kHalf;
    return glm::vec3(x, height(x, z), z);
  });
  for (const glm::vec2 at : {glm::vec2(-5, -5), {5, -2}, {0, 4}, {2, 0}})
    made.lamps.emplace_back(at.x, height(at.x, at.y) + 0.6f, at.y);
  return made;
}

struct Named {
  std::string_view name;
  Made (*make)();
};
constexpr std::array<Named, 6> kMade = {{{"meadow", meadow},
                                         {"bush", bush},
                                         {"clutter", clutter},
                                         {"bars", bars},
                                         {"sheets", sheets},
                                         {"hills", hills}}};

scenes::ScenePtr scene_of(std::string_view name, Made made) {
  auto scene = std::make_shared<scenes::Scene>();
  scene->name = name;
  scene->materials.resize(1);
  scene->bounds = {made.mesh.positions.front(), made.mesh.positions.front()};
  for (const glm::vec3& p : made.mesh.positions) {
    scene->bounds.min = glm::min(scene->bounds.min, p);
    scene->bounds.max = glm::max(scene->bounds.max, p);
  }
  scene->triangle_count = made.mesh.triangles.size();
  scenes::Primitive primitive;
  primitive.positions = std::move(made.mesh.positions);
  primitive.normals = std::move(made.mesh.normals);
  primitive.triangles = std::move(made.mesh.triangles);
  scene->meshes = {{std::string(name), {std::move(primitive)}}};
  scene->instances.push_back({0});
  for (const glm::vec3& at : made.lamps) {
    scenes::Light light;
    light.position = at;
    light.intensity = 40.0f;
    scene->lights.push_back(light);
  }
  scene->cameras.resize(1);
  for (size_t i = 0; i < name.size(); ++i)
    scene->content_hash[i] = static_cast<uint8_t>(name[i]);  // none is longer
  return scene;
}

}  // namespace

std::vector<std::string_view> made_scene_names() {
  std::vector<std::string_view> names;
  for (const Named& named : kMade) names.push_back(named.name);
  return names;
}

scenes::ScenePtr made_scene(std::string_view name) {
  const auto* named = std::ranges::find(kMade, name, &Named::name);
  return named == kMade.end() ? nullptr : scene_of(name, named->make());
}

}  // namespace gnomon::bench
