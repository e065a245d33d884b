// Slices, in whatever order and number they arrive, to the tile masks of whole frames.
//
// Keeps the few newest frames that have begun and no more, so memory is bounded whatever a server sends. A frame
// leaves complete, or incomplete when it is given up: its owner then knows which tiles it lacks. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/ids.h"
#include "common/tile_mask.h"
#include "protocol/datagram.h"
#include "protocol/mask_reference.h"

namespace gnomon::client {

struct AssembledFrame {
  FrameId frame;
  TileGrid grid;
  // As common/tile_mask.h lays them out. What did not arrive is all ones: a missing tile casts no false shadow.
  std::vector<uint64_t> words;
  std::vector<bool> arrived;  // one for each word
  size_t words_missing = 0;
  uint32_t slices_received = 0;
  uint32_t slice_count = 0;
  uint32_t server_us = 0;  // the latest slice's: from the camera's arrival to its sending
  uint32_t gpu_us = 0;
  size_t payload_bytes = 0;
  protocol::Moment moment;  // of the scene

  bool referable = true;  // all slices so far are tiles_context: later frames may refer to it

  bool complete() const { return words_missing == 0; }
  TileMaskView mask() const { return {grid, words}; }
  std::vector<uint32_t> missing_tiles() const;  // that lack some light, in increasing order
};

enum class SliceOutcome {
  stored,
  completed,   // the frame's last: take_finished has it
  duplicate,   // stored before
  late,        // of a frame already finished or given up, or of another answer to its camera
  unreadable,  // refers to a frame that is not kept any more, or was never whole: as good as lost
  malformed,   // contradicts the grid, or does not decode
};

class FrameAssembler {
 public:
  static constexpr size_t kDefaultFrames = 4;

  explicit FrameAssembler(TileGrid grid, size_t max_frames = kDefaultFrames);

  const TileGrid& grid() const { return grid_; }

  // Keep whole frames of tiles_context for later ones to refer to; the newest of them.
  void keep_references() { keeps_references_ = true; }
  FrameId newest_reference() const { return newest_reference_; }

  // A frame newer than all when `max_frames` are open gives up the oldest of them.
  SliceOutcome add(const protocol::FrameSlice& slice);

  // Finishes a frame as it is; nothing happens if it has not begun or is finished.
  void give_up(FrameId frame);

  // Complete and given-up frames, in the order in which they finished. Hand the frame back to `recycle` when done
  // with it, and its memory serves a later one.
  std::optional<AssembledFrame> take_finished();
  void recycle(AssembledFrame frame);

 private:
  struct Open {
    AssembledFrame frame;
    std::vector<bool> slices;  // received
  };

  // Which of the last 64 frames are finished; all older ones count as finished.
  class FinishedWindow {
   public:
    bool contains(FrameId frame) const;
    void insert(FrameId frame);

   private:
    uint32_t newest_ = 0;
    uint64_t bits_ = 0;  // bit i: newest_ - i
  };

  bool fits(const protocol::SliceHeader& header) const;
  Open* find_or_begin(const protocol::SliceHeader& header);
  AssembledFrame begin_frame(const protocol::SliceHeader& header);
  void mark_arrived(AssembledFrame& frame, const protocol::SliceHeader& header);
  void cover_missing(AssembledFrame& frame, const protocol::SliceHeader& header);
  void finish(std::vector<Open>::iterator open);

  TileGrid grid_;
  size_t max_frames_;
  bool keeps_references_ = false;
  FrameId newest_reference_;
  protocol::ReferenceShelf references_;
  std::vector<Open> open_;  // by increasing frame, at most max_frames_
  FinishedWindow finished_ids_;
  std::vector<AssembledFrame> finished_;
  std::vector<AssembledFrame> spare_;
};

}  // namespace gnomon::client
