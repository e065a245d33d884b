// Meshes: from accessors of any kind to triangle lists. Internal to scenes/gltf/.
#pragma once

#include <cstdint>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/materials.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// Strips and fans become lists; points and lines are left out, and so are vertices that no triangle uses when they
// are many. Normals that are not unit vectors are made so; where one cannot be, the primitive gets none. Skins and
// morph targets stay in their rest pose. Error: names the mesh; also when it has more than `max_triangles`.
Result<Mesh> read_mesh(const Document& document, int index, const Materials& materials, uint64_t max_triangles);

uint64_t triangle_count(const Mesh& mesh);

}  // namespace gnomon::scenes::gltf
