#include "tests/eval/remote/unit_stream.h"

#include <algorithm>

namespace gnomon::remote {

protocol::EncodedMask to_slices(const Unit& unit, size_t max_payload_bytes) {
  protocol::EncodedMask frame;
  frame.bytes = unit.bytes;
  const size_t count = (unit.bytes.size() + max_payload_bytes - 1) / max_payload_bytes;
  for (size_t i = 0; i < count; ++i) {
    protocol::SliceHeader header;
    header.frame = unit.frame;
    header.slice = static_cast<uint16_t>(i);
    header.slice_count = static_cast<uint16_t>(count);
    header.first_tile = unit.number;
    header.tile_count = static_cast<uint32_t>(i * max_payload_bytes + 1);
    header.light_count = unit.key ? 2 : 1;
    frame.slices.push_back(header);
    frame.offsets.push_back(i * max_payload_bytes);
  }
  frame.offsets.push_back(unit.bytes.size());
  return frame;
}

void UnitAssembler::add(const protocol::FrameSlice& slice) {
  const protocol::SliceHeader& header = slice.header;
  if (header.first_tile < next_) return;
  Partial& partial = units_[header.first_tile];
  partial.unit.frame = header.frame;
  partial.unit.number = header.first_tile;
  partial.unit.key = header.light_count == 2;
  partial.slice_count = header.slice_count;
  partial.parts.emplace(header.tile_count, std::vector<uint8_t>(slice.payload.begin(), slice.payload.end()));
  broken_ = broken_ || units_.rbegin()->first > next_ + kPatience;
  while (units_.size() > 2 * kPatience) units_.erase(units_.begin());
}

std::optional<Unit> UnitAssembler::take() {
  auto found = units_.find(next_);
  if (found == units_.end() || !found->second.whole() || (broken_ && !found->second.unit.key)) {
    found = std::find_if(units_.begin(), units_.end(),
                         [](const auto& entry) { return entry.second.unit.key && entry.second.whole(); });
    if (found == units_.end()) return std::nullopt;
  }
  Unit unit = std::move(found->second.unit);
  for (const auto& [offset, part] : found->second.parts)
    unit.bytes.insert(unit.bytes.end(), part.begin(), part.end());
  units_.erase(units_.begin(), std::next(found));
  broken_ = false;
  next_ = unit.number + 1;
  return unit;
}

}  // namespace gnomon::remote
