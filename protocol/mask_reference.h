// A frame's mask as both ends have it, for later frames to refer to.
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

// Immutable, so that threads may share it.
class MaskReference {
 public:
  // `mask`: every word as it is coded, bits that do not matter included.
  // `camera`: what it was seen through, where that is known; the encoder looks for what has moved by it.
  MaskReference(FrameId frame, const TileMaskView& mask, const std::optional<CameraView>& camera = {});

  FrameId frame() const { return frame_; }
  const TileGrid& grid() const { return grid_; }
  const std::optional<CameraView>& camera() const { return camera_; }
  // Of all words; travels with every slice that refers to this, so that a damaged one is noticed.
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

// The newest complete frames that a client has. One thread.
class ReferenceShelf {
 public:
  static constexpr size_t kFrames = 16;

  void add(MaskReferencePtr reference) {
    if (frames_.size() == kFrames) frames_.pop_front();
    frames_.push_back(std::move(reference));
  }
  void clear() { frames_.clear(); }
  // Null: not here, or not any more.
  const MaskReference* find(FrameId frame) const {
    for (const MaskReferencePtr& reference : frames_)
      if (reference->frame() == frame) return reference.get();
    return nullptr;
  }

 private:
  std::deque<MaskReferencePtr> frames_;  // the oldest first
};

}  // namespace gnomon::protocol
