// Which slices have arrived, for the acknowledgements that ride on camera updates.
//
// Acknowledging twice costs nothing, losing an update should cost nothing either: every entry is sent with a few
// updates in a row. One thread.
#pragma once

#include <deque>

#include "protocol/datagram.h"

namespace gnomon::client {

class AckList {
 public:
  static constexpr int kRepeats = 3;

  void received(FrameId frame, uint16_t slice);

  // Fills in the newest entries that still want sending, at most kMaxAcks.
  void fill(protocol::CameraUpdate& update);

 private:
  struct Entry {
    protocol::SliceAck ack;
    int sends_left = kRepeats;
  };

  static constexpr size_t kMaxEntries = 4 * protocol::kMaxAcks;

  std::deque<Entry> entries_;  // the oldest first
};

}  // namespace gnomon::client
