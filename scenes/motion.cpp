#include "scenes/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "scenes/pose.h"

namespace gnomon::scenes {
namespace {

constexpr size_t kEvenSamples = 128;          // steps of a period that are sampled beside the keys
constexpr size_t kMaxWork = size_t{1} << 24;  // transforms that sampling may compute

// Node to world of each moving node.
std::vector<glm::dmat4> transforms_at(const Scene& scene, double seconds) {
  std::vector<glm::dmat4> to_world;
  to_world.reserve(scene.moving_nodes.size());
  for (const MovingNode& node : scene.moving_nodes) {
    NodeTransform local = node.local;
    for (const Channel& channel : node.channels) apply(channel, seconds, local);
    to_world.push_back((node.parent == kNone ? node.parent_to_world : to_world[node.parent]) *
                       local_transform(local));
  }
  return to_world;
}

double in_seconds(SceneTime time) { return static_cast<double>(time.count()) * 1e-6; }

// The times to sample, increasing: all keys, and steps of equal length; thinned out if there are too many.
std::vector<double> sample_times(const Scene& scene) {
  std::vector<double> times;
  for (const MovingNode& node : scene.moving_nodes) {
    for (const Channel& channel : node.channels)
      times.insert(times.end(), channel.times.begin(), channel.times.end());
  }
  for (size_t i = 0; i <= kEvenSamples; ++i) {
    times.push_back(in_seconds(scene.period) * static_cast<double>(i) / kEvenSamples);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  const size_t each = scene.moving_nodes.size() + 8 * scene.instances.size() + 1;
  const size_t most = std::max<size_t>(kMaxWork / each, 2);
  if (times.size() <= most) return times;
  std::vector<double> some;
  for (size_t i = 0; i < most; ++i) some.push_back(times[i * (times.size() - 1) / (most - 1)]);
  return some;
}

using Corners = std::array<glm::vec3, 8>;

// The corners of the box around a mesh. Precondition: the mesh has a primitive with positions.
Corners corners_of(const Mesh& mesh) {
  Bounds box{mesh.primitives[0].positions[0], mesh.primitives[0].positions[0]};
  for (const Primitive& primitive : mesh.primitives) {
    for (const glm::vec3& p : primitive.positions) {
      box.min = glm::min(box.min, p);
      box.max = glm::max(box.max, p);
    }
  }
  Corners corners;
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<size_t>(i)] = {(i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y,
                                       (i & 4) ? box.max.z : box.min.z};
  }
  return corners;
}

// A place that is no number is everywhere, where a minimum would pass it over.
void add_to(Bounds& bounds, glm::vec3 p, bool first) {
  constexpr float kEverywhere = std::numeric_limits<float>::infinity();
  const bool is_place = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  if (first) bounds = {p, p};
  bounds.min = is_place ? glm::min(bounds.min, p) : glm::vec3(-kEverywhere);
  bounds.max = is_place ? glm::max(bounds.max, p) : glm::vec3(kEverywhere);
}

// Accumulates the bounds of one instance's box over the samples.
struct Sweep {
  Corners corners;
  uint32_t moved_by;
  Corners last{};
  float farthest = 0;  // largest distance that a corner moves from one sample to the next
  Bounds bounds{};

  void add(const glm::mat4& to_world, bool first) {
    for (size_t i = 0; i < corners.size(); ++i) {
      const glm::vec3 p(to_world * glm::vec4(corners[i], 1.0f));
      if (!first) farthest = std::max(farthest, glm::distance(p, last[i]));
      add_to(bounds, p, first && i == 0);
      last[i] = p;
    }
  }
};

}  // namespace

SceneTime within_period(const Scene& scene, SceneTime since_start) {
  if (scene.period.count() <= 0) return SceneTime(0);
  const SceneTime rest = since_start % scene.period;
  return rest.count() < 0 ? rest + scene.period : rest;
}

std::vector<Instance> moved_instances(const Scene& scene, SceneTime time) {
  std::vector<Instance> moved;
  if (!moves(scene)) return moved;
  const std::vector<glm::dmat4> to_world = transforms_at(scene, in_seconds(time));
  for (const Instance& instance : scene.instances) {
    if (instance.moved_by != kNone) moved.push_back({instance.mesh, glm::mat4(to_world[instance.moved_by])});
  }
  return moved;
}

std::vector<Light> lights_at(const Scene& scene, const std::vector<Light>& lights, SceneTime time) {
  std::vector<Light> moved = lights;
  if (!moves(scene)) return moved;
  const std::vector<glm::dmat4> to_world = transforms_at(scene, in_seconds(time));
  for (Light& light : moved) {
    if (light.moved_by != kNone) place_light(to_world[light.moved_by], light);
  }
  return moved;
}

std::shared_ptr<Scene> frozen_at(const Scene& scene, SceneTime time) {
  auto frozen = std::make_shared<Scene>(scene);
  frozen->lights = lights_at(scene, scene.lights, time);
  for (Light& light : frozen->lights) light.moved_by = kNone;
  const std::vector<Instance> moved = moved_instances(scene, time);
  auto next = moved.begin();
  for (Instance& instance : frozen->instances) {
    if (instance.moved_by != kNone) instance = *next++;
  }
  frozen->moving_nodes.clear();
  frozen->period = SceneTime(0);
  return frozen;
}

Bounds moved_lights_bounds(const Scene& scene) {
  Bounds all;
  bool first = true;
  for (const double seconds : sample_times(scene)) {
    const std::vector<glm::dmat4> to_world = transforms_at(scene, seconds);
    for (const Light& light : scene.lights) {
      if (light.moved_by == kNone) continue;
      add_to(all, glm::vec3(to_world[light.moved_by][3]), std::exchange(first, false));
    }
  }
  return all;
}

Bounds moved_bounds(const Scene& scene, const Bounds& bounds) {
  std::vector<Sweep> sweeps;
  for (const Instance& instance : scene.instances) {
    if (instance.moved_by != kNone) sweeps.push_back({corners_of(scene.meshes[instance.mesh]), instance.moved_by});
  }
  bool first = true;
  for (const double seconds : sample_times(scene)) {
    const std::vector<glm::dmat4> to_world = transforms_at(scene, seconds);
    for (Sweep& sweep : sweeps) sweep.add(glm::mat4(to_world[sweep.moved_by]), first);
    first = false;
  }
  Bounds all = bounds;
  for (const Sweep& sweep : sweeps) {
    all.min = glm::min(all.min, sweep.bounds.min - 0.5f * sweep.farthest);
    all.max = glm::max(all.max, sweep.bounds.max + 0.5f * sweep.farthest);
  }
  return all;
}

}  // namespace gnomon::scenes
