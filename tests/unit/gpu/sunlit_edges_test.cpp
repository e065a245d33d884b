// Single pixels of sunlight in the temple: are they light, or rounding?
//
// They are light. A mask has one bit for each pixel's centre, so that what the sun reaches in less than a pixel's width
// is a single bright pixel or a row of them: bevels, a few millimetres wide, that face the sun along blocks of a wall that
// turns away from it; light through the 8 mm joints between the blocks, at the doorway's jambs and below the roof; and
// light between the leaves of the ivy and the rays of the sun disc.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "gpu/scene/resident_scene.h"
#include "scenes/loader.h"
#include "scenes/world_mesh.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 1280, kHeight = 720;
constexpr uint32_t kSun = 0;  // of the temple's lights

CameraView camera_at(const scenes::Scene& scene, float seconds) {
  const scenes::CameraPath& path = scene.paths.at(0);
  const scenes::CameraPose pose = scenes::pose_at(path, scene.cameras[path.camera].rest.vertical_fov, seconds);
  CameraView view;
  view.position = pose.position;
  view.orientation = pose.orientation;
  view.tan_up = view.tan_down = std::tan(0.5f * pose.vertical_fov);
  view.tan_left = view.tan_right = view.tan_up * kWidth / kHeight;
  return view;
}

struct Place {
  uint32_t x, y;
};

// Calls `visit` for the pixels around one.
template <class Visit>
void around(const Place& p, Visit visit) {
  for (uint32_t v = p.y - 1; v <= p.y + 1; ++v)
    for (uint32_t u = p.x - 1; u <= p.x + 1; ++u)
      if (u != p.x || v != p.y) visit(u, v);
}

// Pixels in the sun with none or one of their neighbours in it.
std::vector<Place> specks_of(const ProbedFrame& frame) {
  std::vector<Place> specks;
  for (uint32_t y = 1; y + 1 < kHeight; ++y)
    for (uint32_t x = 1; x + 1 < kWidth; ++x) {
      if (!frame.mask().lit(x, y, kSun)) continue;
      uint32_t lit = 0;
      around({x, y}, [&](uint32_t u, uint32_t v) { lit += frame.mask().lit(u, v, kSun); });
      if (lit <= 1) specks.push_back({x, y});
    }
  return specks;
}

class SunlitEdges : public testing::TestWithParam<float> {};

TEST_P(SunlitEdges, AreLightThatMeetsNoTriangle) {
  const auto loaded = scenes::load_scene(std::filesystem::path(GNOMON_SCENES_DIR) / "temple.glb");
  ASSERT_TRUE(loaded) << loaded.error().message;
  const scenes::Scene& scene = **loaded;
  ASSERT_EQ(scene.lights.at(kSun).type, scenes::LightType::directional);
  auto probe = SurfaceProbe::create(device_options("bvh"), *loaded);
  ASSERT_TRUE(probe) << probe.error().message;
  const CameraView camera = camera_at(scene, GetParam());
  const auto frame = probe->render(camera, kWidth, kHeight);
  ASSERT_TRUE(frame) << frame.error().message;

  const scenes::WorldMesh mesh = scenes::build_world_mesh(scene);
  const EmbreeOracle oracle(*loaded, true);
  const exact::TracedLight sun = traced_light(scene.lights[kSun], scene.bounds);
  const std::vector<Place> specks = specks_of(*frame);
  size_t hidden = 0, moved = 0, still_lit = 0;
  for (const Place& speck : specks) {
    const SurfaceSample& here = frame->samples[size_t{speck.y} * kWidth + speck.x];
    const auto segment = exact::shadow_segment(camera.position, {here.position, here.normal}, sun);
    ASSERT_TRUE(segment.traced);
    // No triangle of the scene lies between, tested one by one, and Embree finds none either.
    for (uint32_t t = 0; t < mesh.opaque_count; ++t) {
      const glm::uvec3 c = mesh.triangles[t];
      hidden += exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[c.x],
                                              mesh.positions[c.y], mesh.positions[c.z]);
    }
    hidden += oracle.occluded(segment.origin, segment.origin + segment.direction);
    // It is no accident of rounding, which is of micrometres here: the light is still there beside the point.
    for (const glm::vec3 step : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}) {
      for (const float millimetres : {-0.5f, 0.5f}) {
        const glm::vec3 along = step - glm::dot(step, here.normal) * here.normal;
        const glm::vec3 beside = segment.origin + 1e-3f * millimetres * along;
        ++moved;
        still_lit += !oracle.occluded(beside, beside + segment.direction);
      }
    }
  }
  std::printf("%.2f s: %zu specks, %zu hidden, %.1f%% lit half a millimetre away\n",
              static_cast<double>(GetParam()), specks.size(), hidden,
              100.0 * static_cast<double>(still_lit) / static_cast<double>(std::max<size_t>(moved, 1)));
  EXPECT_GT(specks.size(), 3u);
  EXPECT_EQ(hidden, 0u);
  EXPECT_GT(static_cast<double>(still_lit), 0.9 * static_cast<double>(moved));
}

// Of frame 3 of 12 of the flight, of frame 3 and frame 7 of 8.
INSTANTIATE_TEST_SUITE_P(Temple, SunlitEdges, testing::Values(12.5f, 18.75f, 43.75f));

}  // namespace
}  // namespace gnomon::test
