#include "tests/unit/gpu/made_scenes.h"

#include <random>

namespace gnomon::test {
namespace {

void set_bounds(scenes::Scene& scene) {
  scene.bounds = {glm::vec3(1e30f), glm::vec3(-1e30f)};
  for (const scenes::Mesh& mesh : scene.meshes)
    for (const scenes::Primitive& primitive : mesh.primitives) {
      scene.triangle_count += primitive.triangles.size();
      for (const glm::vec3& p : primitive.positions) {
        scene.bounds.min = glm::min(scene.bounds.min, p);
        scene.bounds.max = glm::max(scene.bounds.max, p);
      }
    }
}

scenes::Primitive square(float height, float half_side, uint32_t material) {
  scenes::Primitive p;
  p.material = material;
  const float h = half_side;
  p.positions = {{-h, height, -h}, {-h, height, h}, {h, height, h}, {h, height, -h}};
  p.normals.assign(4, {0, 1, 0});
  p.uvs = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  p.triangles = {{0, 1, 2}, {0, 2, 3}};
  return p;
}

std::shared_ptr<scenes::Scene> two_squares(const scenes::Light& light, float half_side) {
  auto scene = std::make_shared<scenes::Scene>();
  scene->name = "two squares";
  scene->materials.resize(2);
  scene->meshes.push_back({"floor and square", {square(0, 4, 0), square(1, half_side, 1)}});
  scene->instances.resize(1);
  scene->lights = {light};
  scene->cameras.resize(1);
  set_bounds(*scene);
  return scene;
}

}  // namespace

scenes::ScenePtr make_scene(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles,
                            std::vector<scenes::Light> lights) {
  auto scene = std::make_shared<scenes::Scene>();
  scene->name = "made";
  scene->materials.resize(1);
  scenes::Primitive primitive;
  primitive.positions = std::move(positions);
  primitive.triangles = std::move(triangles);
  scene->meshes.push_back({"made", {std::move(primitive)}});
  scene->instances.resize(1);
  scene->lights = std::move(lights);
  scene->cameras.resize(1);
  set_bounds(*scene);
  return scene;
}

scenes::Light point_light(glm::vec3 position) {
  scenes::Light light;
  light.position = position;
  return light;
}

scenes::Light spot_light(glm::vec3 position, glm::vec3 direction, float outer_cone_cos) {
  scenes::Light light = point_light(position);
  light.type = scenes::LightType::spot;
  light.direction = glm::normalize(direction);
  light.outer_cone_cos = outer_cone_cos;
  light.inner_cone_cos = 0.5f * (1.0f + outer_cone_cos);
  return light;
}

scenes::Light sun(glm::vec3 direction) {
  scenes::Light light;
  light.type = scenes::LightType::directional;
  light.direction = glm::normalize(direction);
  return light;
}

scenes::ScenePtr triangle_soup(uint32_t seed, uint32_t triangles, uint32_t lights) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f), around(-1.0f, 1.0f);
  const auto point = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
  const auto offset = [&] { return glm::vec3(around(random), around(random), around(random)); };
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> faces;
  for (uint32_t i = 0; i < triangles; ++i) {
    // Most are small; every fourth is long, every eighth a sliver, some lie in an axis plane.
    const glm::vec3 p0 = point();
    glm::vec3 p1 = p0 + offset() * (i % 4 == 0 ? 0.7f : 0.15f);
    glm::vec3 p2 = p0 + offset() * 0.15f;
    if (i % 8 == 0) p2 = glm::mix(p0, p1, unit(random)) + offset() * 1e-4f;
    if (i % 16 == 1) p1[i / 16 % 3] = p2[i / 16 % 3] = p0[i / 16 % 3];
    const uint32_t base = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), {p0, p1, p2});
    faces.emplace_back(base, base + 1, base + 2);
  }
  std::vector<scenes::Light> all;
  for (uint32_t i = 0; i < lights; ++i) {
    if (i % 4 == 1) {
      all.push_back(spot_light(point() * 2.0f - 0.5f, offset(), 0.6f));
    } else if (i % 4 == 2) {
      all.push_back(sun(offset()));
    } else {
      all.push_back(point_light(point() * 2.0f - 0.5f));
      if (i % 4 == 3) all.back().range = 1.0f;
    }
  }
  return make_scene(std::move(positions), std::move(faces), std::move(all));
}

scenes::ScenePtr with_areas(const scenes::Scene& scene, float reach) {
  auto made = std::make_shared<scenes::Scene>(scene);
  std::mt19937 random(99);
  std::uniform_real_distribution<float> around(-1.0f, 1.0f);
  uint32_t shape = 0;
  for (scenes::Light& light : made->lights) {
    if (light.type == scenes::LightType::directional) continue;
    const glm::vec3 u = glm::normalize(glm::vec3(around(random), around(random), around(random)));
    const glm::vec3 v = glm::normalize(glm::cross(u, glm::vec3(around(random), around(random), around(random))));
    switch (shape++ % 3) {
      case 0: light.area = {scenes::LightShape::sphere, reach * u, reach * v}; break;
      case 1: light.area = {scenes::LightShape::rectangle, 0.6f * reach * u, 0.4f * reach * v}; break;
      default: light.area = {scenes::LightShape::disc, 0.8f * reach * u, 0.8f * reach * v}; break;
    }
  }
  return made;
}

scenes::MovingNode swing(glm::vec3 from, glm::vec3 to) {
  scenes::MovingNode node;
  node.channels.push_back(
      {.path = scenes::Channel::Path::translation, .times = {0, 1, 2}, .values = {{from, 0}, {to, 0}, {from, 0}}});
  node.channels.push_back({.path = scenes::Channel::Path::rotation,
                           .times = {0, 1, 2},
                           .values = {{0, 0, 0, 1}, {0, 0.6f, 0, 0.8f}, {0, 0, 0, 1}}});
  return node;
}

scenes::ScenePtr swinging_soup(uint32_t seed, WhatMoves what) {
  auto scene = std::make_shared<scenes::Scene>(*triangle_soup(seed, 200, 4));
  scene->moving_nodes = {swing({-0.1f, 0, 0}, {0.3f, 0.2f, 0.1f}), swing({0.2f, 1.4f, 0.5f}, {0.9f, 1.2f, 0.3f})};
  scene->period = std::chrono::seconds(2);
  if (what.body) {
    scene->meshes.push_back(triangle_soup(seed + 100, 60, 1)->meshes[0]);
    scene->instances.push_back({1, glm::mat4(1.0f), 0});
  }
  if (what.light) scene->lights[0].moved_by = 1;
  scene->bounds = scenes::moved_bounds(*scene, scene->bounds);
  return scene;
}

scenes::ScenePtr square_over_floor(const scenes::Light& light) { return two_squares(light, 0.5f); }

scenes::ScenePtr checks_over_floor(const scenes::Light& light, uint32_t cells, scenes::AlphaMode mode) {
  auto scene = two_squares(light, 1.0f);
  scenes::Texture texture;
  texture.width = texture.height = cells;
  texture.has_alpha = true;
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint8_t alpha = (x + y) % 2 == 0 ? 255 : 0;
      texture.rgba.insert(texture.rgba.end(), {200, 200, 200, alpha});
    }
  scene->textures.push_back(std::move(texture));
  scene->materials[1].alpha_mode = mode;
  scene->materials[1].base_color_texture = 0;
  return scene;
}

}  // namespace gnomon::test
