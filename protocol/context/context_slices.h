// tiles_context: slices whose every decision is coded with the probability that its surroundings give it. WIRE.md has
// the format; tile_walk.h the order; slice_model.h the probabilities.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "protocol/codec.h"
#include "protocol/context/camera_motion.h"
#include "protocol/mask_reference.h"
#include "protocol/slice_layout.h"

namespace gnomon::protocol::context {

// A frame laid out for the encoder. Several threads may encode different units of it.
struct FrameTiles {
  TileGrid grid;
  std::vector<PackedClass> classes;          // of each word
  std::vector<uint64_t> words;               // mixed ones; the others become what a decoder will have
  const MaskReference* reference = nullptr;  // of the same grid
  std::optional<CameraMotion> camera;        // since the reference, where it is known

  // `now`: the camera of this frame.
  void refer_to(const MaskReference* frame, const std::optional<CameraView>& now);
  void take(const PackedMaskView& mask);
  void take(const TileMaskView& mask);
};

// One thread's; serves frame after frame.
class UnitEncoder {
 public:
  UnitEncoder();
  ~UnitEncoder();

  // Appends slices of `unit`: whole lights, or some tiles of one light.
  void encode(FrameTiles& frame, const SliceRange& unit, size_t max_payload_bytes, EncodedFrame& out);

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

// Parts of a frame that may be encoded side by side: the same ones however many threads there are.
std::vector<SliceRange> plan_units(const FrameTiles& frame, size_t max_payload_bytes);

// As in codec.h.
bool lacks_reference(std::span<const uint8_t> payload, const TileGrid& grid, const ReferenceShelf* references);

// As decode_slice. Memory is kept for the thread's next call.
Result<void> decode(const SliceRange& range, std::span<const uint8_t> payload, const TileGrid& grid,
                    const ReferenceShelf* references, std::span<uint64_t> words);

}  // namespace gnomon::protocol::context
