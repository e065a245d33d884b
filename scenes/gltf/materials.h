// Materials and the textures of their base colours. Internal to scenes/gltf/.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// The set of uvs that a material's base colour texture uses, and their transform (KHR_texture_transform).
struct TextureCoordinates {
  int set = 0;
  glm::mat3 transform{1.0f};
};

struct Materials {
  std::vector<Material> materials;              // those of the file, then the default material
  std::vector<TextureCoordinates> coordinates;  // one for each material
  std::vector<Texture> textures;
  uint32_t default_material = 0;
};

// Which base colour textures are read: all, only those that an alpha test needs, or all as the files that they are,
// with texels only for those of alpha tests.
enum class Reads { colours, alpha_tests, encoded };

// A base colour texture that is missing, damaged or neither PNG nor JPEG is left out with a warning, and its surface
// keeps the plain base colour. Error: an alpha test needs such a texture, so that shadows would be wrong; a texture is
// beyond the limits; or a material has a number that is not finite.
Result<Materials> read_materials(Document& document, Reads reads);

}  // namespace gnomon::scenes::gltf
