// Meshes: from accessors of any kind to triangle lists. Internal to scenes/gltf/.
#pragma once

#include <cstdint>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/materials.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// Reads mesh `index`. Strips and fans become lists; points and lines are left out, and so are the unused vertices of a
// primitive that has more vertices than corners. Normals are normalised; if one cannot be, the primitive gets none.
// Skins and morph targets stay in their rest pose. Error: the mesh is not valid or has more than `max_triangles`; the
// message names the mesh.
Result<Mesh> read_mesh(const Document& document, int index, const Materials& materials, uint64_t max_triangles);

uint64_t triangle_count(const Mesh& mesh);

}  // namespace gnomon::scenes::gltf
