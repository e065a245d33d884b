// What the built-in scenes promise: their size, their lights, sound meshes, a flight through free space.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "scenes/assets/built_in.h"
#include "tests/unit/scenes/assets/clearance.h"

namespace gnomon::scenes::assets {
namespace {

constexpr float kLeastClearance = 0.15f;  // metres between the eye and any surface

struct Promise {
  const char* name;
  Stage (*make)();
  uint64_t least_triangles;
  size_t lights;
  float seconds;
};

// Making a scene takes most of a test's time: each is made once.
const Stage& made(const Promise& promise) {
  static std::map<std::string, Stage> stages;
  auto found = stages.find(promise.name);
  if (found == stages.end()) found = stages.emplace(promise.name, promise.make()).first;
  return found->second;
}

class BuiltInScene : public testing::TestWithParam<Promise> {
 protected:
  const Stage& stage_ = made(GetParam());
};

TEST_P(BuiltInScene, has_the_promised_size_lights_and_duration) {
  EXPECT_EQ(stage_.name, GetParam().name);
  EXPECT_GE(stage_.triangle_count(), GetParam().least_triangles);
  EXPECT_EQ(stage_.lights.size(), GetParam().lights);
  EXPECT_EQ(stage_.flight.back().seconds, GetParam().seconds);
}

TEST_P(BuiltInScene, meshes_are_sound) {
  for (const Model& model : stage_.models) {
    for (const Part& part : model.parts) {
      SCOPED_TRACE(model.name + ", " + stage_.materials[part.material].name);
      const Mesh& mesh = part.mesh;
      const auto count = static_cast<uint32_t>(mesh.positions.size());
      ASSERT_FALSE(mesh.triangles.empty());
      ASSERT_EQ(mesh.normals.size(), count);
      for (uint32_t v = 0; v < count; ++v) {
        ASSERT_TRUE(std::isfinite(glm::dot(mesh.positions[v], glm::vec3(1)))) << v;
        ASSERT_NEAR(glm::length(mesh.normals[v]), 1.0f, 1e-4f) << v;
      }
      for (const glm::uvec3& t : mesh.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), count);
      const bool textured = stage_.materials[part.material].cutout != kNoImage;
      ASSERT_EQ(mesh.uvs.size(), textured ? count : 0u);
    }
  }
}

// Normals agree with the winding, and solids enclose a positive volume: both face outwards.
TEST_P(BuiltInScene, surfaces_face_outwards) {
  for (const Model& model : stage_.models) {
    for (const Part& part : model.parts) {
      SCOPED_TRACE(model.name + ", " + stage_.materials[part.material].name);
      const Mesh& mesh = part.mesh;
      double volume = 0;
      size_t against = 0;
      for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        volume += glm::dot(a, glm::cross(b, c)) / 6;
        const glm::dvec3 normals = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
        against += glm::dot(glm::cross(b - a, c - a), normals) < 0;
      }
      EXPECT_LE(against, mesh.triangles.size() / 100);
      const bool solid = stage_.materials[part.material].cutout == kNoImage;
      EXPECT_TRUE(volume > 0 || !solid) << volume;
    }
  }
}

TEST_P(BuiltInScene, flight_is_a_closed_smooth_loop) {
  const std::vector<CameraKey>& keys = stage_.flight;
  EXPECT_EQ(keys.front().seconds, 0.0f);
  EXPECT_LT(glm::distance(keys.front().position, keys.back().position), 1e-4f);
  EXPECT_GT(std::abs(glm::dot(keys.front().orientation, keys.back().orientation)), 0.99999f);
  for (size_t k = 1; k < keys.size(); ++k) {
    const float seconds = keys[k].seconds - keys[k - 1].seconds;
    ASSERT_GT(seconds, 0.0f);
    EXPECT_LT(glm::distance(keys[k].position, keys[k - 1].position) / seconds, 2.0f)
        << "faster than a walk, key " << k;
    const float cosine = std::min(glm::dot(keys[k].orientation, keys[k - 1].orientation), 1.0f);
    EXPECT_LT(2 * std::acos(cosine) / seconds, 1.5f) << "radians a second, key " << k;
  }
}

TEST_P(BuiltInScene, camera_stays_clear_of_everything) {
  const World world(stage_);
  constexpr size_t kStep = 15;  // half a second
  for (size_t k = 0; k < stage_.flight.size(); k += kStep) {
    const glm::vec3 eye = stage_.flight[k].position;
    ASSERT_GE(world.clearance(eye, kLeastClearance), kLeastClearance) << "at " << stage_.flight[k].seconds << " s";
    ASSERT_TRUE(world.in_free_space(eye, {0.31f, -0.83f, 0.47f})) << "at " << stage_.flight[k].seconds << " s";
  }
}

TEST_P(BuiltInScene, lights_hang_in_free_space) {
  const World world(stage_);
  for (const Light& light : stage_.lights) {
    SCOPED_TRACE(light.name);
    EXPECT_GT(light.intensity, 0);
    EXPECT_NEAR(glm::length(light.direction), 1.0f, 1e-5f);
    if (light.kind == LightKind::directional) continue;
    EXPECT_GT(world.clearance(light.position, 0.05f), 0.03f);
    for (const glm::vec3 direction : {glm::vec3(0.31f, -0.83f, 0.47f), glm::vec3(-0.7f, 0.1f, 0.6f)}) {
      EXPECT_TRUE(world.in_free_space(light.position, direction));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Assets, BuiltInScene,
                         testing::Values(Promise{"living_room", make_living_room, 150'000, 3, 14.0f},
                                         Promise{"temple", make_temple, 500'000, 8, 50.0f}),
                         [](const auto& scene) { return std::string(scene.param.name); });

}  // namespace
}  // namespace gnomon::scenes::assets
