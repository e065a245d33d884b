// The seal of the data channel: turns header and body into a datagram that nobody else can make, read or repeat, and
// back. WIRE.md, "the seal", is the specification.
//
// The header travels in clear and is authenticated with the body. Numbers of a session's datagrams count up; they are
// the AEAD's nonce and say which epoch's key applies (protocol/seal_keys.h).
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
  std::span<const uint8_t> body;  // the seal's, until its next open
};

// Why a datagram was not opened. All but the last are found without any cryptography.
enum class Rejection : uint8_t {
  header,    // too short, too long, or of another protocol
  session,   // of another session
  replayed,  // its number has been seen, or lies behind the window or beyond the next epoch
  forged,    // its tag is wrong: damaged, or made by somebody else
};

enum class Side { client, server };

// What each side's sending starts from; the same on both ends.
struct SealSecrets {
  Secret client{};
  Secret server{};
};

// How far a seal has come: all that is needed to go on from there with the same keys, and no number taken twice. Plain
// memory, kept up to date with every datagram, so that it may be shared with whoever comes after.
struct SealState {
  uint64_t sent = 0;    // the newest sequence number
  uint64_t opened = 0;  // the newest that was opened: what comes before is refused by whoever goes on from here
  EpochSecret sending;
  EpochSecret receiving;
};
SealState first_state(const SealSecrets& secrets, Side side);

// One per session and side. One thread at a time. Allocates nothing for a datagram but where an epoch begins.
class Seal {
 public:
  // Goes on from `state`, which outlives it.
  Seal(SessionId session, CipherId cipher, SealState& state, Side side, uint64_t epoch_datagrams = kEpochDatagrams);

  // `epoch_datagrams` is kEpochDatagrams but in tests.
  Seal(SessionId session, CipherId cipher, const SealSecrets& secrets, Side side,
       uint64_t epoch_datagrams = kEpochDatagrams);
  ~Seal();  // wipes a state of its own

  // Writes a datagram of sealed_size(body.size()) bytes to `out`; takes the next sequence number of this side and
  // returns it. The body may stand where its sealed form goes (at kHeaderBytes of `out`), but not elsewhere in `out`.
  uint64_t seal(DatagramKind kind, std::span<const uint8_t> body, std::span<uint8_t> out);
  static constexpr size_t sealed_size(size_t body_bytes) { return kHeaderBytes + body_bytes + kTagBytes; }

  // The same, in the place of what `datagram` held.
  uint64_t seal(DatagramKind kind, std::span<const uint8_t> body, std::vector<uint8_t>& datagram);

  // Takes the next sequence number for something that goes another way; the other side passes it.
  uint64_t skip();
  void pass(uint64_t sequence);

  // Empty: see rejection().
  std::optional<Opened> open(std::span<const uint8_t> datagram);
  Rejection rejection() const { return rejection_; }  // of the last that was not opened

 private:
  std::optional<Opened> reject(Rejection why);
  void begin(SealKeys& keys, uint64_t sequence);

  SessionId session_;
  uint64_t epoch_datagrams_;
  SealState own_;  // where nobody else keeps it
  SealState& state_;
  SealKeys sending_;
  SealKeys receiving_;
  uint64_t forged_ = 0;
  ReplayWindow window_;
  Rejection rejection_ = Rejection::header;
  std::vector<uint8_t> text_;  // as long as the longest datagram that this side takes
};

}  // namespace gnomon::protocol
