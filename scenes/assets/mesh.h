// Triangles while they are being modelled: closed surfaces, counter-clockwise seen from outside, metres, Y up.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

namespace gnomon::scenes::assets {

struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // one for each position, unit
  std::vector<glm::vec2> uvs;      // empty, or one for each position
  std::vector<glm::uvec3> triangles;
};

// Adds `part`, placed, to `to`. A mirroring placement keeps the surface facing outwards.
void append(Mesh& to, const Mesh& part, const glm::mat4& placement = glm::mat4(1.0f));

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

// A flat lid over the ring of vertices first, first + 1, ... with vertices of its own, so that its rim is sharp. It
// faces where the ring runs counter-clockwise, or away from there if `reversed`.
void add_cap(Mesh& mesh, uint32_t first, uint32_t count, bool reversed);

Mesh placed(const Mesh& mesh, const glm::mat4& placement);

// Moves every position through `move` and makes the normals anew with smooth_normals.
void deform(Mesh& mesh, const std::function<glm::vec3(glm::vec3)>& move);

// Normals as the area-weighted mean over the faces around a point. Vertices at the same place share theirs where
// their present normals differ by less than `crease_degrees`; beyond that the edge stays sharp. Drops triangles
// without area and vertices that none uses; the rest keep their order.
void smooth_normals(Mesh& mesh, float crease_degrees = 180.0f);

// Placements, right to left as usual: at(...) * turned(...) * scaled(...).
glm::mat4 at(float x, float y, float z);
glm::mat4 at(glm::vec3 position);
glm::mat4 turned(float degrees, glm::vec3 axis = {0.0f, 1.0f, 0.0f});
glm::mat4 scaled(float x, float y, float z);
glm::mat4 scaled(float factor);
// Turns +Y into `direction`, with any roll.
glm::mat4 pointing(glm::vec3 direction);

}  // namespace gnomon::scenes::assets
