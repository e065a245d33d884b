// Small scenes made in code, with known answers.
#pragma once

#include <cstdint>

#include "scenes/motion.h"

namespace gnomon::test {

// A scene of one material and one mesh; lights and bounds as given and found.
scenes::ScenePtr make_scene(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles,
                            std::vector<scenes::Light> lights);

scenes::Light point_light(glm::vec3 position);
scenes::Light spot_light(glm::vec3 position, glm::vec3 direction, float outer_cone_cos);
scenes::Light sun(glm::vec3 direction);

// Triangles of every shape within the unit cube, slivers and needles among them, around a few lights of every kind.
scenes::ScenePtr triangle_soup(uint32_t seed, uint32_t triangles, uint32_t lights);

// The lights that are not directional get an extent, of every shape in turn; `reach`: of the largest.
scenes::ScenePtr with_areas(const scenes::Scene& scene, float reach);

struct WhatMoves {
  bool body = false, light = false;
};

// Moves from one place to another and back within two seconds, and turns.
scenes::MovingNode swing(glm::vec3 from, glm::vec3 to);

// A soup that rests and, where asked, one that swings through it and a first light that swings above it.
scenes::ScenePtr swinging_soup(uint32_t seed, WhatMoves what);

// The square |x|, |z| < 0.5 at height 1 over the floor |x|, |z| < 4 at height 0, under `light`.
scenes::ScenePtr square_over_floor(const scenes::Light& light);

// The same square, twice as wide and with an alpha test: a texture of `cells` x `cells` checks, of which those with
// even x + y are solid.
scenes::ScenePtr checks_over_floor(const scenes::Light& light, uint32_t cells, scenes::AlphaMode mode);

}  // namespace gnomon::test
