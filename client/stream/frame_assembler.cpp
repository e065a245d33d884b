#include "client/stream/frame_assembler.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "protocol/codec.h"

namespace gnomon::client {
namespace {

// Calls `visit` with the index of every word that a slice holds.
template <class Visit>
void for_each_word(const protocol::SliceHeader& header, const TileGrid& grid, Visit visit) {
  for (size_t light = header.first_light; light < size_t{header.first_light} + header.light_count; ++light) {
    const size_t first = light * grid.tile_count() + header.first_tile;
    for (size_t word = first; word < first + header.tile_count; ++word) visit(word);
  }
}

}  // namespace

std::vector<uint32_t> AssembledFrame::missing_tiles() const {
  std::vector<uint32_t> missing;
  for (uint32_t tile = 0; tile < grid.tile_count(); ++tile) {
    for (uint32_t plane = 0; plane < grid.planes; ++plane) {
      if (arrived[size_t{plane} * grid.tile_count() + tile]) continue;
      missing.push_back(tile);
      break;
    }
  }
  return missing;
}

FrameAssembler::FrameAssembler(TileGrid grid, size_t max_frames)
    : FrameAssembler(grid, LightPlanes(std::vector<bool>(grid.planes), 1), max_frames) {}

FrameAssembler::FrameAssembler(TileGrid grid, LightPlanes planes, size_t max_frames)
    : grid_(grid), planes_(std::move(planes)), max_frames_(max_frames) {
  assert(max_frames > 0);
  assert(planes_.total() == grid.planes);
}

SliceOutcome FrameAssembler::add(const protocol::FrameSlice& slice) {
  return add(slice, [&](std::span<uint64_t> words) {
    if (protocol::lacks_reference(slice.header, slice.payload, grid_, &references_))
      return SliceOutcome::unreadable;
    const auto decoded = protocol::decode_slice(slice.header, slice.payload, grid_, words, &references_);
    return decoded ? SliceOutcome::stored : SliceOutcome::malformed;
  });
}

SliceOutcome FrameAssembler::add_decoded(const protocol::FrameSlice& slice, std::span<const uint64_t> words) {
  return add(slice, [&](std::span<uint64_t> into) {
    if (words.size() != size_t{slice.header.tile_count} * slice.header.light_count) return SliceOutcome::malformed;
    size_t from = 0;
    for_each_word(slice.header, grid_, [&](size_t word) { into[word] = words[from++]; });
    return SliceOutcome::stored;
  });
}

template <class Decode>
SliceOutcome FrameAssembler::add(const protocol::FrameSlice& slice, Decode decode) {
  const auto& header = slice.header;
  if (!fits(header)) return SliceOutcome::malformed;
  Open* open = find_or_begin(header);
  if (!open) return SliceOutcome::late;
  AssembledFrame& frame = open->frame;
  // The server may have answered a repeated camera twice, each time cut into other slices.
  if (header.slice_count != frame.slice_count || header.moment != frame.moment) return SliceOutcome::late;
  if (open->slices[header.slice]) return SliceOutcome::duplicate;
  const SliceOutcome decoded = decode(std::span(frame.words));
  if (decoded == SliceOutcome::malformed) cover_missing(frame, header);
  if (decoded != SliceOutcome::stored) return decoded;
  open->slices[header.slice] = true;
  mark_arrived(frame, header);
  frame.referable = frame.referable && header.codec == protocol::CodecId::tiles_context;
  ++frame.slices_received;
  frame.payload_bytes += slice.payload.size();
  frame.server_us = std::max(frame.server_us, header.server_us);
  frame.gpu_us = std::max(frame.gpu_us, header.gpu_us);
  if (frame.slices_received < frame.slice_count) return SliceOutcome::stored;
  // All slices have arrived but tiles are missing: the server cut this frame wrongly.
  const auto outcome = frame.complete() ? SliceOutcome::completed : SliceOutcome::malformed;
  finish(open_.begin() + (open - open_.data()));
  return outcome;
}

void FrameAssembler::give_up(FrameId frame) {
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.frame.frame == frame; });
  if (found != open_.end()) finish(found);
}

std::optional<AssembledFrame> FrameAssembler::take_finished() {
  if (finished_.empty()) return std::nullopt;
  AssembledFrame frame = std::move(finished_.front());
  finished_.erase(finished_.begin());
  return frame;
}

void FrameAssembler::recycle(AssembledFrame frame) {
  if (spare_.size() < max_frames_) spare_.push_back(std::move(frame));
}

bool FrameAssembler::fits(const protocol::SliceHeader& header) const {
  return header.slice < header.slice_count && header.slice_count <= grid_.word_count() && header.tile_count > 0 &&
         header.light_count > 0 && uint64_t{header.first_tile} + header.tile_count <= grid_.tile_count() &&
         uint32_t{header.first_light} + header.light_count <= grid_.planes;
}

// nullptr if the slice is too late for its frame.
FrameAssembler::Open* FrameAssembler::find_or_begin(const protocol::SliceHeader& header) {
  const auto place = std::lower_bound(open_.begin(), open_.end(), header.frame,
                                      [](const Open& o, FrameId id) { return o.frame.frame < id; });
  if (place != open_.end() && place->frame.frame == header.frame) return &*place;
  if (finished_ids_.contains(header.frame)) return nullptr;
  auto at = place - open_.begin();
  if (open_.size() == max_frames_) {
    if (at == 0) return nullptr;  // older than all those kept
    finish(open_.begin());
    --at;
  }
  Open begun{begin_frame(header), std::vector<bool>(header.slice_count)};
  return &*open_.insert(open_.begin() + at, std::move(begun));
}

AssembledFrame FrameAssembler::begin_frame(const protocol::SliceHeader& header) {
  AssembledFrame frame;
  if (!spare_.empty()) {
    frame.words = std::move(spare_.back().words);
    frame.arrived = std::move(spare_.back().arrived);
    spare_.pop_back();
  }
  frame.frame = header.frame;
  frame.grid = grid_;
  frame.planes = planes_;
  frame.words.assign(grid_.word_count(), ~uint64_t{0});
  frame.arrived.assign(grid_.word_count(), false);
  frame.words_missing = grid_.word_count();
  frame.slice_count = header.slice_count;
  frame.moment = header.moment;
  return frame;
}

void FrameAssembler::mark_arrived(AssembledFrame& frame, const protocol::SliceHeader& header) {
  for_each_word(header, grid_, [&](size_t word) {
    if (frame.arrived[word]) return;
    frame.arrived[word] = true;
    --frame.words_missing;
  });
}

// Marks the tiles of a slice that did not decode, which left them unspecified, as missing.
void FrameAssembler::cover_missing(AssembledFrame& frame, const protocol::SliceHeader& header) {
  for_each_word(header, grid_, [&](size_t word) {
    frame.words[word] = ~uint64_t{0};
    if (!frame.arrived[word]) return;
    frame.arrived[word] = false;
    ++frame.words_missing;
  });
}

void FrameAssembler::finish(std::vector<Open>::iterator open) {
  const AssembledFrame& frame = open->frame;
  finished_ids_.insert(frame.frame);
  if (keeps_references_ && frame.complete() && frame.referable) {
    references_.add(std::make_shared<protocol::MaskReference>(frame.frame, frame.mask()));
    newest_reference_ = std::max(newest_reference_, frame.frame);
  }
  finished_.push_back(std::move(open->frame));
  open_.erase(open);
}

bool FrameAssembler::FinishedWindow::contains(FrameId frame) const {
  if (frame.value > newest_) return false;
  const uint32_t age = newest_ - frame.value;
  return age >= 64 || ((bits_ >> age) & 1);
}

void FrameAssembler::FinishedWindow::insert(FrameId frame) {
  if (frame.value > newest_) {
    const uint32_t step = frame.value - newest_;
    bits_ = step < 64 ? bits_ << step : 0;
    newest_ = frame.value;
  }
  const uint32_t age = newest_ - frame.value;
  if (age < 64) bits_ |= uint64_t{1} << age;
}

}  // namespace gnomon::client
