// The seal of the data channel: encrypts and authenticates datagrams, opens those of the other side and rejects
// replayed ones. WIRE.md, "the seal", is the specification.
//
// The header travels in clear text and is authenticated together with the body. A datagram's sequence number determines
// the AEAD's nonce and the epoch whose key applies (protocol/seal_keys.h).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/datagram.h"
#include "protocol/replay_window.h"
#include "protocol/seal_keys.h"

namespace gnomon::protocol {

struct Opened {
  Header header;
  std::span<const uint8_t> body;  // borrowed from the seal until its next open()
};

// Why a datagram was not opened. All but the last are found before anything is deciphered.
enum class Rejection : uint8_t {
  header,    // too short, too long, or of another protocol
  session,   // of another session
  replayed,  // its number was seen, is behind the window, or is of an epoch without keys
  forged,    // its tag is wrong (damaged or forged), or too many before it were
};

enum class Side { client, server };

// The first secret of each direction, named after its sender; both ends have both.
struct SealSecrets {
  Secret client{};
  Secret server{};
};

// The progress of a seal: all that a successor needs to continue with the same keys without using a sequence number
// twice. Plain memory that the seal updates with every datagram, so that it may be shared with a later process.
struct SealState {
  uint64_t sent = 0;    // the newest sequence number taken
  uint64_t opened = 0;  // the newest sequence number opened; a successor rejects it and all before it
  EpochSecret sending;
  EpochSecret receiving;
};
SealState first_state(const SealSecrets& secrets, Side side);

// One per session and side; one thread at a time. Opening, and sealing into a span, allocate only as an epoch begins.
class Seal {
 public:
  // Continues from `state`, which must outlive the seal and is kept up to date. `epoch_datagrams` differs from
  // kEpochDatagrams in tests only.
  Seal(SessionId session, CipherId cipher, SealState& state, Side side, uint64_t epoch_datagrams = kEpochDatagrams);

  // Starts from `secrets`, with a state of its own.
  Seal(SessionId session, CipherId cipher, const SealSecrets& secrets, Side side,
       uint64_t epoch_datagrams = kEpochDatagrams);
  ~Seal();  // wipes its own state

  // Writes a datagram to `out`, which has sealed_size(body.size()) bytes, with this side's next sequence number, and
  // returns that. `body` may begin at kHeaderBytes of `out` (sealing in place), but must not overlap `out` otherwise.
  uint64_t seal(DatagramKind kind, std::span<const uint8_t> body, std::span<uint8_t> out);
  static constexpr size_t sealed_size(size_t body_bytes) { return kHeaderBytes + body_bytes + kTagBytes; }

  // As above; replaces the contents of `datagram`.
  uint64_t seal(DatagramKind kind, std::span<const uint8_t> body, std::vector<uint8_t>& datagram);

  // For bodies that travel outside datagrams (protocol::Data) but share their sequence numbers: skip() takes the next
  // one, and the other side calls pass() with it, so that it follows the sender into the next epoch.
  uint64_t skip();
  void pass(uint64_t sequence);

  uint64_t taken() const { return state_.sent; }  // the newest sequence number of this side; 0 before the first

  uint64_t newest_opened() const { return window_.newest(); }  // the other side's highest; 0 before the first

  // nullopt if the datagram is rejected: see rejection().
  std::optional<Opened> open(std::span<const uint8_t> datagram);
  Rejection rejection() const { return rejection_; }  // of the datagram rejected last

 private:
  std::optional<Opened> reject(Rejection why);
  void begin(SealKeys& keys, uint64_t sequence);

  SessionId session_;
  uint64_t epoch_datagrams_;
  SealState own_;  // used unless the caller keeps the state
  SealState& state_;
  SealKeys sending_;
  SealKeys receiving_;
  uint64_t forged_ = 0;
  ReplayWindow window_;
  Rejection rejection_ = Rejection::header;
  std::vector<uint8_t> text_;  // sized for the longest datagram that this side accepts
};

}  // namespace gnomon::protocol
