// Triangle meshes of the generators: closed surfaces, counter-clockwise seen from outside, in metres, Y up.
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

// Appends `part`, transformed by `placement`, to `to`. The surface faces outwards even if the placement mirrors.
void append(Mesh& to, const Mesh& part, const glm::mat4& placement = glm::mat4(1.0f));

void add_quad(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

// Adds a flat lid over the ring of `count` vertices from `first` on, with vertices of its own, so that its rim is
// sharp. It faces the side from which the ring runs counter-clockwise, or the other side if `reversed`.
void add_cap(Mesh& mesh, uint32_t first, uint32_t count, bool reversed);

Mesh placed(const Mesh& mesh, const glm::mat4& placement);

// Replaces each position p by move(p) and recomputes the normals with smooth_normals.
void deform(Mesh& mesh, const std::function<glm::vec3(glm::vec3)>& move);

// Sets each normal to the area-weighted mean over the faces around the point. Vertices at the same place share their
// normal if the normals of their own faces differ by less than `crease_degrees`; otherwise the edge stays sharp.
// Removes triangles without area and unused vertices; the others keep their order.
void smooth_normals(Mesh& mesh, float crease_degrees = 180.0f);

// Placements, which are applied from right to left: at(...) * turned(...) * scaled(...).
glm::mat4 at(float x, float y, float z);
glm::mat4 at(glm::vec3 position);
glm::mat4 turned(float degrees, glm::vec3 axis = {0.0f, 1.0f, 0.0f});
glm::mat4 scaled(float x, float y, float z);
glm::mat4 scaled(float factor);
// A rotation of +Y into `direction`, with an arbitrary roll.
glm::mat4 pointing(glm::vec3 direction);

}  // namespace gnomon::scenes::assets
