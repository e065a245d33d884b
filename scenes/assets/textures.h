// Textures of colour for the built-in scenes: computed, and seamless wherever they repeat.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace gnomon::scenes::assets {

// What a surface is made of. Of those with a grain (wood), it runs along the texture's u.
enum class Pattern {
  stone,     // limestone: bedding, stains, pits
  marble,    // veins
  plaster,   // nearly even
  wood,      // rings, streaks, pores
  weave,     // plain cloth
  wool,      // tufts
  leather,   // pebbled
  clay,      // fired, with the potter's rings
  ground,    // dry grass and bare earth
  foliage,   // many small leaves
  patina,    // bronze turned green in places
  hammered,  // beaten metal
  ember      // glowing coals between ashes
};

struct ColourTexture {
  std::vector<uint8_t> png;
  // Of its texels in linear light. A material divides its base colour by this, and keeps its colour on the whole.
  glm::vec3 mean{1.0f};
};

// Equal patterns give equal bytes.
ColourTexture make_texture(Pattern pattern);

}  // namespace gnomon::scenes::assets
