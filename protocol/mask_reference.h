// A frame's mask as both ends have it, to which the slices of later frames can refer.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/ids.h"
#include "common/tile_mask.h"
#include "protocol/context/bit_rows.h"
#include "protocol/types.h"

namespace gnomon::protocol {

// Immutable: any number of threads may read it.
class MaskReference {
 public:
  // `mask` has every word as a decoder has it, including the bits that do not matter. `camera` is the frame's, nullopt
  // if it is unknown; only the encoder uses it, to search for motion.
  MaskReference(FrameId frame, const TileMaskView& mask, const std::optional<CameraView>& camera = {});

  FrameId frame() const { return frame_; }
  const TileGrid& grid() const { return grid_; }
  const std::optional<CameraView>& camera() const { return camera_; }
  // The low 32 bits of XXH3-64 of all words. Every slice that refers to this frame carries it, so that a decoder whose
  // copy differs detects that.
  uint32_t checksum() const { return checksum_; }
  const context::BitRows& rows(uint32_t light) const { return lights_[light]; }

 private:
  FrameId frame_;
  TileGrid grid_;
  std::optional<CameraView> camera_;
  uint32_t checksum_;
  std::vector<context::BitRows> lights_;
};

using MaskReferencePtr = std::shared_ptr<const MaskReference>;

// The kFrames newest complete frames that a client has. Not thread-safe.
class ReferenceShelf {
 public:
  static constexpr size_t kFrames = 16;

  void add(MaskReferencePtr reference) {
    if (frames_.size() == kFrames) frames_.pop_front();
    frames_.push_back(std::move(reference));
  }
  void clear() { frames_.clear(); }
  // nullptr if the shelf does not hold the frame, or no longer does.
  const MaskReference* find(FrameId frame) const {
    for (const MaskReferencePtr& reference : frames_)
      if (reference->frame() == frame) return reference.get();
    return nullptr;
  }

 private:
  std::deque<MaskReferencePtr> frames_;  // the oldest first
};

}  // namespace gnomon::protocol
