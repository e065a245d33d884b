// What moves in a scene, and where it is at a time.
//
// All that moves plays on one clock and begins anew together, every Scene::period: after the longest animation. Where
// things are is a function of the scene and of a time in whole microseconds alone; who has both, has the same floats.
// Any thread.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "scenes/scene.h"

namespace gnomon::scenes {

using SceneTime = std::chrono::microseconds;

inline bool moves(const Scene& scene) { return !scene.moving_nodes.empty(); }

// The time within one period; 0 in a scene where nothing moves.
SceneTime within_period(const Scene& scene, SceneTime since_start);

// The instances that move, where they are at that time: as instances at rest, in their order.
std::vector<Instance> moved_instances(const Scene& scene, SceneTime time);

// All lights; those that move where they are at that time. `lights`: the scene's, or what became of them.
std::vector<Light> lights_at(const Scene& scene, const std::vector<Light>& lights, SceneTime time);

// The scene as it is at that time, for ever.
std::shared_ptr<Scene> frozen_at(const Scene& scene, SceneTime time);

// Of whatever moves, at any time, and of `bounds`. Found by sampling the animations, and widened by half of what
// anything moves from one sample to the next.
Bounds moved_bounds(const Scene& scene, const Bounds& bounds);

}  // namespace gnomon::scenes
