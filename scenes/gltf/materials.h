// Materials and the textures of their base colours. Internal to scenes/gltf/.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// Which uvs a material's base colour texture wants, and what is done to them (KHR_texture_transform).
struct TextureCoordinates {
  int set = 0;
  glm::mat3 transform{1.0f};
};

struct Materials {
  std::vector<Material> materials;              // those of the file, then a default one
  std::vector<TextureCoordinates> coordinates;  // one for each material
  std::vector<Texture> textures;
  uint32_t default_material = 0;
};

// A base colour texture that is missing, broken or neither PNG nor JPEG is left out with a warning: its surface keeps
// the plain base colour. Where an alpha test needs it, that is an error: shadows would be wrong.
Result<Materials> read_materials(Document& document, uint64_t max_texels);

}  // namespace gnomon::scenes::gltf
