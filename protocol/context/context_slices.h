// The codec tiles_context, which codes every decision of a slice with a probability predicted from its surroundings.
// WIRE.md has the format, tile_walk.h the order and slice_model.h the probabilities.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "protocol/codec.h"
#include "protocol/context/camera_motion.h"
#include "protocol/mask_reference.h"
#include "protocol/slice_layout.h"

namespace gnomon::protocol::context {

// A frame laid out for the encoder. Several threads may encode different units of it concurrently.
struct FrameTiles {
  TileGrid grid;
  std::vector<PackedClass> classes;  // of each word
  std::vector<uint64_t> words;       // of mixed tiles; encoding fills in the others as a decoder will have them
  const MaskReference* reference = nullptr;  // of the same grid; not owned; null: none
  std::optional<CameraMotion> camera;        // motion since the reference, if known

  // `frame` (may be null) outlives this. `now` is the camera of this frame, nullopt if it is unknown.
  void refer_to(const MaskReference* frame, const std::optional<CameraView>& now);
  void take(const PackedMaskView& mask);
  void take(const TileMaskView& mask);
};

// One per thread: it reuses its working memory from frame to frame.
class UnitEncoder {
 public:
  UnitEncoder();
  ~UnitEncoder();

  // Appends the slices of `unit`, which is some lights with all their tiles, or some tiles of one light.
  void encode(FrameTiles& frame, const SliceRange& unit, size_t max_payload_bytes, EncodedMask& out);

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

// Divides a frame into units that may be encoded in parallel. The division does not depend on the number of threads.
std::vector<SliceRange> plan_units(const FrameTiles& frame, size_t max_payload_bytes);

// See codec.h.
bool lacks_reference(std::span<const uint8_t> payload, const TileGrid& grid, const ReferenceShelf* references);

// As decode_slice(), for a range inside the grid. Working memory is kept for the thread's next call.
Result<void> decode(const SliceRange& range, std::span<const uint8_t> payload, const TileGrid& grid,
                    const ReferenceShelf* references, std::span<uint64_t> words);

}  // namespace gnomon::protocol::context
