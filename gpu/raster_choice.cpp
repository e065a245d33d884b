#include "gpu/raster_choice.h"

#include <algorithm>

#include "gpu/frame/frame_slot.h"

namespace gnomon::gpu {
namespace {

constexpr uint32_t kTrials = 8;  // of each way; the best counts, because an idle device raises its clock slowly
constexpr uint32_t kWidth = 1280, kHeight = 720;

// A hilly floor of 2 x 300 x 300 triangles below the camera.
scenes::ScenePtr trial_scene() {
  constexpr uint32_t kCells = 300;
  scenes::Primitive floor;
  for (uint32_t z = 0; z <= kCells; ++z)
    for (uint32_t x = 0; x <= kCells; ++x)
      floor.positions.emplace_back(0.1f * static_cast<float>(x), 0.03f * static_cast<float>((x * 7 + z * 5) % 11),
                                   0.1f * static_cast<float>(z));
  for (uint32_t z = 0; z < kCells; ++z)
    for (uint32_t x = 0; x < kCells; ++x) {
      const uint32_t p = z * (kCells + 1) + x, q = p + kCells + 1;
      floor.triangles.push_back({p, q, q + 1});
      floor.triangles.push_back({p, q + 1, p + 1});
    }
  auto scene = std::make_shared<scenes::Scene>();
  scene->materials.resize(1);
  scene->bounds = {glm::vec3(0), glm::vec3(0.1f * kCells, 0.3f, 0.1f * kCells)};
  scene->triangle_count = floor.triangles.size();
  scene->meshes.push_back({"floor", {std::move(floor)}});
  scene->instances.resize(1);
  return scene;
}

CameraView trial_camera() {
  CameraView camera;
  camera.position = {15, 4, 30};
  camera.orientation = glm::angleAxis(-0.35f, glm::vec3(1, 0, 0));
  camera.tan_up = camera.tan_down = 0.5f;
  camera.tan_left = camera.tan_right = 0.5f * kWidth / kHeight;
  return camera;
}

Result<uint64_t> best_ns(const DevicePtr& device, const ResidentScene& scene, const std::string& pass) {
  const auto plan = FramePlan::compile(device, {pass}, nullptr);
  if (!plan) return plan.error();
  auto slot = FrameSlot::create(device, *plan);
  if (!slot) return slot.error();
  const TileGrid grid{kWidth, kHeight, 0};
  if (auto room = slot->reserve(*plan, scene, grid); !room) return room.error();
  uint64_t best = UINT64_MAX;
  for (uint32_t i = 0; i < kTrials; ++i) {
    const auto value = slot->submit(*plan, scene, scene.pose({}), {trial_camera(), grid});
    if (!value) return value.error();
    if (auto passed = device->queue().wait(*value); !passed) return passed.error();
    const auto timing = slot->timing(*plan);
    if (!timing) return timing.error();
    best = std::min(best, timing->total_ns);
  }
  return best;
}

}  // namespace

Result<std::string> choose_raster(const DevicePtr& device, std::string_view wanted) {
  const std::string hardware("hardware"), compute("compute");
  const bool possible = device->features().atomic_int64;
  if (wanted == hardware) return hardware;
  if (wanted == compute) {
    if (possible) return compute;
    return Error{"raster 'compute' needs 64-bit atomics, which device '" + device->info().name + "' lacks"};
  }
  if (wanted != "auto")
    return Error{"no raster is called '" + std::string(wanted) + "'; there are auto, hardware, compute"};
  if (!possible || device->info().type == VK_PHYSICAL_DEVICE_TYPE_CPU) return hardware;
  const auto scene = ResidentScene::create(device, trial_scene(), nullptr);
  if (!scene) return scene.error();
  // The two ways take turns, so that neither is measured at a lower clock only.
  uint64_t best[2] = {UINT64_MAX, UINT64_MAX};
  for (int turn = 0; turn < 4; ++turn) {
    const auto ns = best_ns(device, **scene, turn % 2 == 0 ? "gbuffer" : "gbuffer_compute");
    if (!ns) return ns.error();
    best[turn % 2] = std::min(best[turn % 2], *ns);
  }
  return best[1] < best[0] ? compute : hardware;
}

std::vector<std::string> with_raster(std::vector<std::string> passes, std::string_view raster) {
  if (raster == "compute")
    std::replace(passes.begin(), passes.end(), std::string("gbuffer"), std::string("gbuffer_compute"));
  return passes;
}

}  // namespace gnomon::gpu
