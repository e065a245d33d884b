// Closed building blocks of the models. All face outwards and carry smooth normals.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

// A box with one flat bevel round every edge: 44 triangles that shade as a rounded block. Bevel 0: 12 triangles.
Mesh bevel_box(glm::vec3 low, glm::vec3 high, float bevel);

// A box with edges of `radius`, `round` segments a quarter, the flats split into `flat` spans (for deforming).
// Centred on the origin.
Mesh rounded_box(glm::vec3 size, float radius, int round, int flat = 1);

// A rounded box that swells by `puff` in the middle of its large faces (those of ±Y) as stuffed cloth does, with
// faint wrinkles that `seed` varies. Centred on the origin.
Mesh cushion(glm::vec3 size, float puff, int detail, uint32_t seed);

// Turns a profile of (radius, height), listed so that the outside lies to its right when walked (upwards for an
// outer wall), about Y. A point listed twice makes a sharp edge. Ends with radius 0 close the shape.
Mesh lathe(const std::vector<glm::vec2>& profile, int segments);

// The same for a profile of corners which a spline rounds: `steps` spans between neighbours.
Mesh turned_vessel(const std::vector<glm::vec2>& profile, int segments, int steps);

Mesh sphere(float radius, int segments);
Mesh cylinder(float radius, float low, float high, int segments, float bevel);

// A round bar along `path`, radius(t) with t in [0, 1]; both ends closed.
Mesh tube(const std::vector<glm::vec3>& path, const std::function<float(float)>& radius, int sides);
Mesh tube(const std::vector<glm::vec3>& path, float radius, int sides);

// A Catmull-Rom curve through `points`, `steps` spans between neighbours.
std::vector<glm::vec3> curve(const std::vector<glm::vec3>& points, int steps);
std::vector<glm::vec2> curve(const std::vector<glm::vec2>& points, int steps);

// The open surface f(u, v), u and v in [0, 1]; the front is where du x dv points. Has texture coordinates (u, v).
Mesh surface(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f);

// That surface given a thickness towards its back, closed round its rim.
Mesh sheet(int spans_u, int spans_v, float thickness, const std::function<glm::vec3(float, float)>& f);

// A surface that closes on itself in u, its two open ends (v = 0 and v = 1) shut by flat caps. du x dv points out.
Mesh barrel(int spans_u, int spans_v, const std::function<glm::vec3(float, float)>& f);

// A prism over a polygon that its centroid sees whole, counter-clockwise in XY, from z = 0 to `depth`.
Mesh prism(const std::vector<glm::vec2>& outline, float depth);

}  // namespace gnomon::scenes::assets
