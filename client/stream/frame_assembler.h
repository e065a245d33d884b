// Assembles slices, in whatever order and number they arrive, into the tile masks of frames.
//
// Only the few newest frames of which slices have arrived are kept, so that memory is bounded whatever a server sends.
// A frame is handed over complete, or incomplete if it was given up; it then knows which tiles it lacks. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/ids.h"
#include "common/light_planes.h"
#include "common/tile_mask.h"
#include "protocol/datagram.h"
#include "protocol/mask_reference.h"

namespace gnomon::client {

struct AssembledFrame {
  FrameId frame;
  TileGrid grid;
  LightPlanes planes;  // which of the grid's planes are whose
  // Laid out as common/tile_mask.h says. Those that did not arrive are all ones: a missing tile casts no false shadow, of
  // an area light neither.
  std::vector<uint64_t> words;
  std::vector<bool> arrived;  // one for each word
  size_t words_missing = 0;
  uint32_t slices_received = 0;
  uint32_t slice_count = 0;
  uint32_t server_us = 0;  // from the camera's arrival at the server to the frame's sending
  uint32_t gpu_us = 0;
  size_t payload_bytes = 0;
  protocol::Moment moment;  // of the scene, which the frame shows

  bool referable = true;  // all slices so far are tiles_context: later frames may refer to it

  bool complete() const { return words_missing == 0; }
  TileMaskView mask() const { return {grid, words}; }
  // How many of the light's sample points pixel (x, y) sees, of planes.samples(light); 1 is all of a light without extent.
  uint32_t seen(uint32_t x, uint32_t y, uint32_t light) const { return planes.seen(mask(), x, y, light); }
  std::vector<uint32_t> missing_tiles() const;  // tiles that lack some plane, in increasing order
};

enum class SliceOutcome {
  stored,
  completed,   // the frame's last: take_finished() returns the frame
  duplicate,   // stored before
  late,        // of a frame already finished or given up, or of another answer to its camera
  unreadable,  // refers to a frame that is no longer kept, or was never complete: it counts as lost
  malformed,   // contradicts the grid, or does not decode
};

class FrameAssembler {
 public:
  static constexpr size_t kDefaultFrames = 4;

  explicit FrameAssembler(TileGrid grid, size_t max_frames = kDefaultFrames);
  // `planes`: of the lights, in all the grid's.
  FrameAssembler(TileGrid grid, LightPlanes planes, size_t max_frames = kDefaultFrames);

  const TileGrid& grid() const { return grid_; }
  const LightPlanes& planes() const { return planes_; }

  // Keeps complete frames of tiles_context, to which slices of later frames may refer; and the newest that is kept.
  void keep_references() { keeps_references_ = true; }
  FrameId newest_reference() const { return newest_reference_; }

  // Adds a slice to its frame. If `max_frames` frames are open, the first slice of another one that is newer than the
  // oldest of them gives that oldest frame up.
  SliceOutcome add(const protocol::FrameSlice& slice);

  // The same for a slice that somebody else has decoded, with references as they are here: `words` are its own, light by
  // light.
  SliceOutcome add_decoded(const protocol::FrameSlice& slice, std::span<const uint64_t> words);

  // Whether a slice is of this grid; others are malformed.
  bool fits(const protocol::SliceHeader& header) const;

  // Finishes a frame as it is. No effect if none of its slices has arrived or it is finished already.
  void give_up(FrameId frame);

  // The next complete or given-up frame, in the order in which they finished; nullopt if there is none. A frame that is
  // handed back to recycle() has its memory reused for a later one.
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
    uint64_t bits_ = 0;  // bit i stands for frame newest_ - i
  };

  // `decode`: writes the slice's words into those of a frame, and says stored, or why it could not.
  template <class Decode>
  SliceOutcome add(const protocol::FrameSlice& slice, Decode decode);
  Open* find_or_begin(const protocol::SliceHeader& header);
  AssembledFrame begin_frame(const protocol::SliceHeader& header);
  void mark_arrived(AssembledFrame& frame, const protocol::SliceHeader& header);
  void cover_missing(AssembledFrame& frame, const protocol::SliceHeader& header);
  void finish(std::vector<Open>::iterator open);

  TileGrid grid_;
  LightPlanes planes_;
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
