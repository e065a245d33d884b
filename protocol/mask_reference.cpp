#define XXH_INLINE_ALL
#include "protocol/mask_reference.h"

#include <xxhash.h>

#include <cassert>

namespace gnomon::protocol {

MaskReference::MaskReference(FrameId frame, const TileMaskView& mask, const std::optional<CameraView>& camera)
    : frame_(frame),
      grid_(mask.grid),
      camera_(camera),
      checksum_(static_cast<uint32_t>(XXH3_64bits(mask.words.data(), mask.words.size_bytes()))),
      lights_(mask.grid.planes) {
  assert(mask.words.size() == grid_.word_count());
  const uint64_t* word = mask.words.data();
  for (context::BitRows& rows : lights_) {
    rows.reset(grid_.tiles_x(), grid_.tiles_y());
    for (uint32_t y = 0; y < grid_.tiles_y(); ++y)
      for (uint32_t x = 0; x < grid_.tiles_x(); ++x, ++word) {
        if (*word != 0) rows.put(static_cast<int>(x), static_cast<int>(y), *word);
      }
    rows.extend();
  }
}

}  // namespace gnomon::protocol
