// Building blocks of the models: closed surfaces, unless stated otherwise, that face outwards and have smooth normals.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

// A box with one flat bevel along every edge: 44 triangles that shade as a rounded block; 12 triangles if `bevel` is 0.
Mesh bevel_box(glm::vec3 low, glm::vec3 high, float bevel);

// A box with edges rounded by `radius`, with `round` segments for each half of an edge's quarter circle; its flat parts
// are divided into `flat` spans, so that they can be deformed. Centred on the origin.
Mesh rounded_box(glm::vec3 size, float radius, int round, int flat = 1);

// A rounded box that swells by `puff` in the middle of its large faces (those of ±Y), as stuffed cloth does, with
// faint wrinkles that depend on `seed`. Centred on the origin.
Mesh cushion(glm::vec3 size, float puff, int detail, uint32_t seed);

// The surface of revolution about Y of a profile of points (radius, height). The outside lies to the right of the
// profile's direction, which is upwards for an outer wall. A repeated point makes a sharp edge. Ends with radius 0
// close the surface.
Mesh lathe(const std::vector<glm::vec2>& profile, int segments);

// As lathe, for a profile of corners that a spline rounds, with `steps` spans between neighbours.
Mesh turned_vessel(const std::vector<glm::vec2>& profile, int segments, int steps);

Mesh sphere(float radius, int segments);
Mesh cylinder(float radius, float low, float high, int segments, float bevel);

// A round bar along `path` of radius(t), t in [0, 1], with both ends closed.
Mesh tube(const std::vector<glm::vec3>& path, const std::function<float(float)>& radius, int sides);
Mesh tube(const std::vector<glm::vec3>& path, float radius, int sides);

// A Catmull-Rom spline through `points`, with `steps` spans between neighbours.
std::vector<glm::vec3> curve(const std::vector<glm::vec3>& points, int steps);
std::vector<glm::vec2> curve(const std::vector<glm::vec2>& points, int steps);

// The open surface f(u, v), u and v in [0, 1], with texture coordinates (u, v). Its front faces along du x dv.
Mesh surface(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f);

// As surface, with a thickness towards its back and a closed rim.
Mesh sheet(int spans_u, int spans_v, float thickness, const std::function<glm::vec3(float, float)>& f);

// A surface that is periodic in u, with its two ends (v = 0 and v = 1) closed by flat caps. Precondition: du x dv
// points outwards.
Mesh barrel(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f);

// A prism over a counter-clockwise polygon in XY, from z = 0 to `depth`. Precondition: every vertex is visible from the
// mean of the vertices.
Mesh prism(const std::vector<glm::vec2>& outline, float depth);

}  // namespace gnomon::scenes::assets
