// Records which slices have arrived, for the acknowledgements that camera updates carry.
//
// Every entry is sent with kRepeats updates in a row, so that the loss of an update costs nothing. One thread.
#pragma once

#include <deque>

#include "protocol/datagram.h"

namespace gnomon::client {

class AckList {
 public:
  static constexpr int kRepeats = 3;

  void received(FrameId frame, uint16_t slice);

  // Fills in the newest entries that are still to be sent, at most kMaxAcks.
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
