// Keys of the data channel, one direction at a time: from the secret that the TLS session exports to the keys of each
// epoch. WIRE.md, "the seal", is the specification.
//
// An epoch is kEpochDatagrams sequence numbers long; each has keys of its own, and its secret is made from the one
// before by a function that cannot be turned round. So no AES-GCM key seals more than what RFC 9001 (6.6) allows it
// (2^23 packets), and who takes a secret from memory cannot read what was sent in earlier epochs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "protocol/types.h"

struct evp_cipher_ctx_st;

namespace gnomon::protocol {

inline constexpr uint64_t kEpochDatagrams = uint64_t{1} << 22;

using Secret = std::array<uint8_t, 32>;

// In the same time, whatever they are.
bool is_equal(const Secret& a, const Secret& b);
// Also where nobody looks at it any more.
void wipe(void* memory, size_t bytes);

// How far one direction has come: an epoch and its secret, which is all that is needed to go on from there. Whoever is
// killed between any two instructions leaves one epoch or the next, whole.
struct EpochSecret {
  uint64_t epoch = 0;
  std::array<Secret, 2> by_parity{};  // this epoch's at epoch % 2

  const Secret& secret() const { return by_parity[epoch % 2]; }
  void go_on(const Secret& next);  // to the next epoch; wipes the secret of this one
};

// Of one epoch, from its secret. The key has 16 bytes for AES-128-GCM and 32 for ChaCha20-Poly1305.
struct AeadKey {
  using Nonce = std::array<uint8_t, 12>;

  AeadKey(CipherId cipher, const Secret& secret);
  ~AeadKey();  // wipes it
  AeadKey(const AeadKey&) = delete;
  std::span<const uint8_t> key() const { return std::span(bytes).first(size); }

  std::array<uint8_t, 32> bytes{};
  size_t size;
  Nonce iv{};  // a datagram's nonce is this, its last bytes XORed with the sequence number
};

// An AEAD with one key. One direction and one thread; its context is made once, and used without allocating.
class Aead {
 public:
  static constexpr size_t kTagBytes = 16;

  Aead(CipherId cipher, const Secret& secret, bool sealing);

  // `out` has room for text and tag, and is text.data() or does not overlap it.
  void seal(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> text, uint8_t* out);

  // `sealed` ends with the tag; `out` has room for what stands before it. False: forged or damaged, and `out` holds
  // nothing of use.
  bool open(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> sealed, uint8_t* out);

 private:
  struct Free {
    void operator()(evp_cipher_ctx_st* context) const;
  };
  AeadKey::Nonce nonce(uint64_t sequence) const;

  std::unique_ptr<evp_cipher_ctx_st, Free> context_;
  AeadKey::Nonce iv_{};
};

// The secret of the next epoch.
Secret next_secret(const Secret& secret);

// The AEADs of one direction's epochs around the newest.
class SealKeys {
 public:
  // `at` outlives this, and is kept up to date.
  SealKeys(CipherId cipher, EpochSecret& at, bool sealing);
  ~SealKeys();  // wipes what it knows
  SealKeys(const SealKeys&) = delete;

  // Of the newest epoch, the one before or the one after; null: of none of these.
  Aead* of(uint64_t epoch);

  // That epoch has begun: one that of() gave an AEAD for.
  void begin(uint64_t epoch);

 private:
  CipherId cipher_;
  bool sealing_;
  EpochSecret& newest_;
  Secret after_;                                     // of the epoch after the newest
  std::array<std::unique_ptr<Aead>, 3> by_epoch_{};  // at epoch % 3
};

// Whether the processor has instructions for AES; without them ChaCha20 is quicker.
bool has_aes_instructions();

}  // namespace gnomon::protocol
