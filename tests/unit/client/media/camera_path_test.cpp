#include "client/media/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace gnomon::client {
namespace {

scenes::CameraPose pose_with_fov(float fov) {
  scenes::CameraPose pose;
  pose.position = {1, 2, 3};
  pose.vertical_fov = fov;
  return pose;
}

// Where a direction in camera space lies on the picture, in pixels from its middle.
glm::vec2 pixel_from_middle(const protocol::CameraView& view, uint32_t width, uint32_t height,
                            glm::vec3 direction) {
  const float x = direction.x / -direction.z, y = direction.y / -direction.z;
  return {(x + view.tan_left) / (view.tan_left + view.tan_right) * static_cast<float>(width) -
              static_cast<float>(width) / 2,
          (view.tan_up - y) / (view.tan_up + view.tan_down) * static_cast<float>(height) -
              static_cast<float>(height) / 2};
}

TEST(ViewOf, ABorderKeepsTheShownRegion) {
  const auto pose = pose_with_fov(0.9f);
  const protocol::CameraView plain = view_of(pose, {.width = 1920, .height = 1080});
  EXPECT_FLOAT_EQ(plain.tan_up, std::tan(0.45f));
  EXPECT_FLOAT_EQ(plain.tan_right, std::tan(0.45f) * 16 / 9);
  for (const auto& [border_x, border_y] : {std::pair{64u, 36u}, {128u, 72u}, {640u, 360u}, {0u, 100u}, {33u, 1u}}) {
    const ViewSize size{1920, 1080, border_x, border_y};
    const protocol::CameraView traced = view_of(pose, size);
    // Dissertation 3.4: new focal length = old focal length x 1920 / prediction buffer width.
    EXPECT_NEAR(1 / traced.tan_right, 1 / plain.tan_right * 1920 / static_cast<float>(size.traced_width()), 1e-6f);
    for (const glm::vec3 d : {glm::vec3(0, 0, -1), glm::vec3(0.3f, 0.2f, -1), glm::vec3(-0.7f, -0.4f, -1)}) {
      const auto shown = pixel_from_middle(plain, 1920, 1080, d);
      const auto in_buffer = pixel_from_middle(traced, size.traced_width(), size.traced_height(), d);
      EXPECT_NEAR(shown.x, in_buffer.x, 1e-3f);
      EXPECT_NEAR(shown.y, in_buffer.y, 1e-3f);
    }
  }
}

TEST(ViewOf, CarriesThePose) {
  auto pose = pose_with_fov(1);
  pose.orientation = glm::quat(0.5f, 0.5f, -0.5f, 0.5f) * 1.001f;
  const auto view = view_of(pose, {.width = 8, .height = 8});
  EXPECT_EQ(view.position, (protocol::Vec3{1, 2, 3}));
  const auto& q = view.orientation;
  EXPECT_NEAR(q[3], 0.5f, 1e-5f);
  EXPECT_NEAR(q[1], -0.5f, 1e-5f);
  EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-6f);
}

// A scene whose camera moves 10 m along x in 4 s.
scenes::ScenePtr moving_scene() {
  auto scene = std::make_shared<scenes::Scene>();
  scene->cameras.push_back({"still", pose_with_fov(0.5f)});
  scene->cameras.push_back({"moving", pose_with_fov(0.7f)});
  scenes::CameraPath path;
  path.camera = 1;
  path.duration_seconds = 4;
  path.chain.resize(1);
  path.channels.push_back({.node = 0,
                           .path = scenes::Channel::Path::translation,
                           .interpolation = scenes::Interpolation::linear,
                           .times = {0, 4},
                           .values = {{0, 0, 0, 0}, {10, 0, 0, 0}}});
  scene->paths.push_back(path);
  return scene;
}

TEST(CameraPath, FollowsTheScenesAnimationAndRepeatsIt) {
  const auto path = CameraPath::of_scene(moving_scene());  // the path shares ownership of the scene
  EXPECT_EQ(path.duration_seconds(), 4);
  EXPECT_NEAR(path.at(0).position.x, 0, 1e-5f);
  EXPECT_NEAR(path.at(1).position.x, 2.5f, 1e-5f);
  EXPECT_NEAR(path.at(4 + 1).position.x, 2.5f, 1e-5f);
  EXPECT_FLOAT_EQ(path.at(3).vertical_fov, 0.7f);
  EXPECT_NEAR(path.at(-3).position.x, 0, 1e-5f);
}

TEST(CameraPath, MovesThroughASceneWhoseCameraStandsStill) {
  auto scene = std::make_shared<scenes::Scene>();
  scene->cameras.push_back({"still", pose_with_fov(0.5f)});
  scene->bounds = {{-5, 0, -5}, {5, 3, 5}};
  const auto path = CameraPath::of_scene(scene);
  std::set<float> xs;
  for (int i = 0; i < 8; ++i) xs.insert(path.at(path.duration_seconds() * i / 8).position.x);
  EXPECT_GT(xs.size(), 3u);
}

TEST(CameraPath, OrbitStartsAtTheDefaultCameraAndStaysNear) {
  protocol::SceneManifest scene;
  scene.bounds_min = {-10, 0, -10};
  scene.bounds_max = {10, 5, 10};
  scene.default_camera.position = {1, 2, 3};
  scene.default_camera.tan_up = scene.default_camera.tan_down = 0.5f;
  const auto path = CameraPath::orbit(scene);
  const auto start = path.at(0);
  EXPECT_NEAR(glm::distance(start.position, glm::vec3(1, 2, 3)), 0, 1e-5f);
  EXPECT_NEAR(std::tan(start.vertical_fov / 2), 0.5f, 1e-5f);
  float farthest = 0;
  for (int i = 0; i < 100; ++i) {
    const auto pose = path.at(path.duration_seconds() * i / 100);
    farthest = std::max(farthest, glm::distance(pose.position, start.position));
  }
  EXPECT_GT(farthest, 0.1f);
  EXPECT_LT(farthest, 2);
}

}  // namespace
}  // namespace gnomon::client
