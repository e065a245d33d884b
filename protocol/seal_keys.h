// The key schedule of one direction of the data channel: from the secret that the TLS session exports to the keys of
// each epoch. WIRE.md, "the seal", is the specification.
//
// An epoch has kEpochDatagrams sequence numbers and keys of its own; its secret is derived from the one before with a
// one-way function (HKDF-Expand, RFC 5869). So no AES-GCM key seals more than the 2^23 packets that RFC 9001 (6.6)
// allows, and a secret taken from memory does not reveal what was sent in earlier epochs.
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

// Compares in constant time.
bool is_equal(const Secret& a, const Secret& b);
// Overwrites the memory, also where the compiler would drop stores that nothing reads.
void wipe(void* memory, size_t bytes);

// The progress of one direction: an epoch and its secret, from which all later keys follow. A process that is killed
// between any two instructions leaves a consistent state, of either this epoch or the next.
struct EpochSecret {
  uint64_t epoch = 0;
  std::array<Secret, 2> by_parity{};  // the current secret is at epoch % 2

  const Secret& secret() const { return by_parity[epoch % 2]; }
  void go_on(const Secret& next);  // advances to the next epoch; wipes the secret of this one
};

// Key and IV of one epoch, derived from its secret. The key has 16 bytes for AES-128-GCM, 32 for ChaCha20-Poly1305.
struct AeadKey {
  using Nonce = std::array<uint8_t, 12>;

  AeadKey(CipherId cipher, const Secret& secret);
  ~AeadKey();  // wipes the key
  AeadKey(const AeadKey&) = delete;
  std::span<const uint8_t> key() const { return std::span(bytes).first(size); }

  std::array<uint8_t, 32> bytes{};
  size_t size;
  Nonce iv{};  // a datagram's nonce is this with its last 8 bytes XORed with the sequence number
};

// An AEAD (RFC 5116) with one key, for one direction and one thread at a time. Allocates in its constructor only.
class Aead {
 public:
  static constexpr size_t kTagBytes = 16;

  Aead(CipherId cipher, const Secret& secret, bool sealing);

  // `out` has room for the text and the tag, and is text.data() or does not overlap `text`.
  void seal(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> text, uint8_t* out);

  // `sealed` ends with the tag; `out` has room for the bytes before it. False if the tag is wrong; `out` is then
  // unspecified.
  bool open(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> sealed, uint8_t* out);

 private:
  struct Free {
    void operator()(evp_cipher_ctx_st* context) const;
  };
  AeadKey::Nonce nonce(uint64_t sequence) const;

  std::unique_ptr<evp_cipher_ctx_st, Free> context_;
  AeadKey::Nonce iv_{};
};

// Derives the secret of the next epoch.
Secret next_secret(const Secret& secret);

// The AEADs of one direction: of the newest epoch and its neighbours. One thread at a time.
class SealKeys {
 public:
  // `at` must outlive this object, which advances it.
  SealKeys(CipherId cipher, EpochSecret& at, bool sealing);
  ~SealKeys();  // wipes the secret of the next epoch
  SealKeys(const SealKeys&) = delete;

  // The AEAD of the newest epoch, the one before or the one after; nullptr for any other and for those before `at`.
  Aead* of(uint64_t epoch);

  // Makes `epoch` the newest if it is the next one. Precondition: of(epoch) gave an AEAD.
  void begin(uint64_t epoch);

 private:
  CipherId cipher_;
  bool sealing_;
  EpochSecret& newest_;
  Secret after_;                                     // secret of the epoch after the newest
  std::array<std::unique_ptr<Aead>, 3> by_epoch_{};  // at epoch % 3
};

// Whether the processor has instructions for AES-GCM; without them ChaCha20-Poly1305 is faster.
bool has_aes_instructions();

}  // namespace gnomon::protocol
