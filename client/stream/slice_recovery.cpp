#include "client/stream/slice_recovery.h"

#include <algorithm>

namespace gnomon::client {

using Rebuilt = std::vector<std::vector<uint8_t>>;

Rebuilt SliceRecovery::add_slice(const protocol::SliceHeader& header, std::span<const uint8_t> body) {
  Frame* frame = find_or_begin(header.frame, header.slice_count);
  if (!frame || !frame->slices[header.slice].empty() || frame->bytes + body.size() > kMaxFrameBytes) return {};
  frame->slices[header.slice].assign(body.begin(), body.end());
  frame->bytes += body.size();
  if (frame->groups == 0) return {};
  return rebuild_group(*frame, static_cast<uint16_t>(header.slice % frame->groups));
}

Rebuilt SliceRecovery::add_parity(const protocol::FrameParity& parity) {
  const protocol::ParityHeader& header = parity.header;
  Frame* frame = find_or_begin(header.frame, header.slice_count);
  if (!frame || (frame->groups != 0 && frame->groups != header.groups)) return {};
  // A server that protects each slice twice sends more than enough; without a bound, shards of no bytes take memory.
  const bool enough = frame->parity.size() >= 2 * frame->slices.size() + protocol::kMaxGroupParity;
  if (enough || frame->bytes + parity.shard.size() > kMaxFrameBytes) return {};
  frame->groups = header.groups;
  for (const Shard& known : frame->parity) {
    if (known.group == header.group && known.index == header.index) return {};
  }
  frame->parity.push_back({header.group, header.index, {parity.shard.begin(), parity.shard.end()}});
  frame->bytes += parity.shard.size();
  return rebuild_group(*frame, header.group);
}

// nullptr if the frame is older than all those kept, or has another number of slices than before.
SliceRecovery::Frame* SliceRecovery::find_or_begin(FrameId id, uint16_t slice_count) {
  auto place = std::lower_bound(frames_.begin(), frames_.end(), id,
                                [](const Frame& frame, FrameId wanted) { return frame.frame < wanted; });
  if (place != frames_.end() && place->frame == id) return place->slices.size() == slice_count ? &*place : nullptr;
  if (frames_.size() == kFrames) {
    if (place == frames_.begin()) return nullptr;
    frames_.pop_front();
    place = std::lower_bound(frames_.begin(), frames_.end(), id,
                             [](const Frame& frame, FrameId wanted) { return frame.frame < wanted; });
  }
  Frame begun;
  begun.frame = id;
  begun.slices.resize(slice_count);
  return &*frames_.insert(place, std::move(begun));
}

Rebuilt SliceRecovery::rebuild_group(Frame& frame, uint16_t group) {
  protocol::Bodies bodies;
  size_t missing = 0;
  for (size_t slice = group; slice < frame.slices.size(); slice += frame.groups) {
    bodies.emplace_back(frame.slices[slice]);
    missing += bodies.back().empty();
  }
  std::vector<protocol::ParityShard> shards;
  for (const Shard& shard : frame.parity) {
    if (shard.group == group) shards.push_back({shard.index, shard.bytes});
  }
  if (missing == 0 || shards.size() < missing) return {};
  Rebuilt rebuilt = protocol::rebuild(bodies, shards);
  size_t next = 0;
  for (size_t slice = group; slice < frame.slices.size() && next < rebuilt.size(); slice += frame.groups) {
    if (frame.slices[slice].empty()) frame.slices[slice] = rebuilt[next++];
  }
  return rebuilt;
}

}  // namespace gnomon::client
