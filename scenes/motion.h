// The motion of a scene: where its moving instances and lights are at a given time.
//
// All animations share one clock and restart together after Scene::period, the duration of the longest animation. All
// places are a function of the scene and of a time in whole microseconds only, so that daemon and client compute the
// same floats. Any thread.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "scenes/scene.h"

namespace gnomon::scenes {

using SceneTime = std::chrono::microseconds;

inline bool moves(const Scene& scene) { return !scene.moving_nodes.empty(); }

// The time within one period; 0 if nothing moves in the scene.
SceneTime within_period(const Scene& scene, SceneTime since_start);

// The moving instances at their places at that time, in their order, as instances at rest. `time`: within a period.
std::vector<Instance> moved_instances(const Scene& scene, SceneTime time);

// All of `lights`, the moving ones at their places at that time. `lights`: the scene's, or changed ones in their place.
std::vector<Light> lights_at(const Scene& scene, const std::vector<Light>& lights, SceneTime time);

// A copy of the scene in which everything rests at its place at that time.
std::shared_ptr<Scene> frozen_at(const Scene& scene, SceneTime time);

// The bounds of `bounds` and of all moving instances at all times. They are found by sampling the animations; each
// instance's bounds are widened by half of the farthest that it moves from one sample to the next.
Bounds moved_bounds(const Scene& scene, const Bounds& bounds);

// The bounds of the moving lights' places, sampled likewise; of a place that is no number, all that there is.
Bounds moved_lights_bounds(const Scene& scene);

}  // namespace gnomon::scenes
