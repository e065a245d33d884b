#include "client/net/ack_list.h"

namespace gnomon::client {

void AckList::received(FrameId frame, uint16_t slice) {
  const auto first = static_cast<uint16_t>(slice / 64 * 64);
  const uint64_t bit = uint64_t{1} << (slice % 64);
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->ack.frame != frame || entry->ack.first_slice != first) continue;
    entry->ack.slices |= bit;
    entry->sends_left = kRepeats;
    return;
  }
  if (entries_.size() == kMaxEntries) entries_.pop_front();
  entries_.push_back({{frame, first, bit}});
}

void AckList::fill(protocol::CameraUpdate& update) {
  update.ack_count = 0;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (update.ack_count == protocol::kMaxAcks) break;
    update.acks[update.ack_count++] = entry->ack;
    --entry->sends_left;
  }
  std::erase_if(entries_, [](const Entry& entry) { return entry.sends_left <= 0; });
}

}  // namespace gnomon::client
