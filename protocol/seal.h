// The one seam for securing the data channel: a Seal turns header and body into a datagram and back.
//
// ClearSeal, the only one so far, authenticates nothing against an attacker: its tag is a keyed checksum that
// catches damage and datagrams of other sessions. It occupies the 16 bytes that an AEAD tag will.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/datagram.h"

namespace gnomon::protocol {

struct Opened {
  Header header;
  std::span<const uint8_t> body;  // borrowed from the datagram (or from the seal, until its next open)
};

enum class Side { client, server };

// One per session and side. One thread at a time.
class Seal {
 public:
  virtual ~Seal() = default;

  // Replaces `datagram` with the sealed one; takes the next sequence number of this side.
  virtual void seal(DatagramKind kind, std::span<const uint8_t> body, std::vector<uint8_t>& datagram) = 0;

  // Empty: not of this session, damaged, or seen before (replay window of 1,024 sequence numbers).
  virtual std::optional<Opened> open(std::span<const uint8_t> datagram) = 0;
};

std::unique_ptr<Seal> make_clear_seal(SessionId session, const Bytes16& key, Side side);

}  // namespace gnomon::protocol
