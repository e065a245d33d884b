#include "tests/unit/gpu/cameras.h"

#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {

using gpu::CameraView;

Cameras::Cameras(const scenes::Scene& scene, uint32_t seed)
    : random_(seed), bounds_(scene.bounds), mesh_(build_world_mesh(scene)) {}

CameraView Cameras::next() {
  const float size = glm::length(bounds_.max - bounds_.min);
  CameraView view;
  view.orientation = glm::normalize(glm::quat(any(), any(), any(), any()) + glm::quat(1e-3f, 0, 0, 0));
  view.near_plane = 1e-3f * size;
  view.position = within();
  switch (kind_++ % 5) {
    case 1: view.position = on_surface(); break;
    case 2: return from_afar(3.0f * size);
    case 3:
      view.tan_left = 0.3f * (1.1f + any()), view.tan_right = 0.9f - view.tan_left;
      view.tan_up = -0.05f * (1.1f + any()), view.tan_down = 0.2f - view.tan_up;
      break;
    case 4: view.near_plane = 0.1f * size; break;
  }
  return view;
}

glm::vec3 Cameras::within() {
  const glm::vec3 where = 0.5f + 0.5f * glm::vec3(any(), any(), any());
  return bounds_.min + where * (bounds_.max - bounds_.min);
}

glm::vec3 Cameras::on_surface() {
  const glm::uvec3 t = mesh_.triangles[random_() % mesh_.triangles.size()];
  return (mesh_.positions[t.x] + mesh_.positions[t.y] + mesh_.positions[t.z]) / 3.0f;
}

CameraView Cameras::from_afar(float distance) {
  const glm::vec3 middle = within();
  const glm::vec3 way = glm::normalize(glm::vec3(any(), any(), any()) + glm::vec3(1e-3f));
  return look_at(middle + distance * way, middle, 0.5f, 320, 180);
}

}  // namespace gnomon::test
