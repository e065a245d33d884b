#include "protocol/seal.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cassert>
#include <cstring>

#include "protocol/replay_window.h"

namespace gnomon::protocol {
namespace {

constexpr uint8_t label(Side sender) { return sender == Side::client ? 'c' : 's'; }

// One seed per direction, so that a datagram sent back to its sender is not taken.
uint64_t direction_seed(const Bytes16& key, Side sender) {
  std::array<uint8_t, 17> bytes;
  std::copy(key.begin(), key.end(), bytes.begin());
  bytes.back() = label(sender);
  return XXH3_64bits(bytes.data(), bytes.size());
}

Bytes16 tag_of(std::span<const uint8_t> header_and_body, uint64_t seed) {
  const XXH128_hash_t hash = XXH3_128bits_withSeed(header_and_body.data(), header_and_body.size(), seed);
  Bytes16 tag;
  std::memcpy(tag.data(), &hash.low64, 8);
  std::memcpy(tag.data() + 8, &hash.high64, 8);
  return tag;
}

class ClearSeal final : public Seal {
 public:
  ClearSeal(SessionId session, const Bytes16& key, Side side)
      : session_(session),
        send_seed_(direction_seed(key, side)),
        receive_seed_(direction_seed(key, side == Side::client ? Side::server : Side::client)) {}

  void seal(DatagramKind kind, std::span<const uint8_t> body, std::vector<uint8_t>& datagram) override {
    datagram.clear();
    append_header(datagram, {.kind = kind, .flags = 0, .session = session_, .sequence = ++sent_});
    datagram.insert(datagram.end(), body.begin(), body.end());
    const Bytes16 tag = tag_of(datagram, send_seed_);
    datagram.insert(datagram.end(), tag.begin(), tag.end());
  }

  std::optional<Opened> open(std::span<const uint8_t> datagram) override {
    if (datagram.size() < kHeaderBytes + kTagBytes || datagram.size() > kMaxDatagramBytes) return std::nullopt;
    const auto header = decode_header(datagram);
    if (!header || header->session != session_) return std::nullopt;
    const auto sealed = datagram.first(datagram.size() - kTagBytes);
    const Bytes16 tag = tag_of(sealed, receive_seed_);
    if (std::memcmp(tag.data(), datagram.data() + sealed.size(), kTagBytes) != 0) return std::nullopt;
    if (!window_.take(header->sequence)) return std::nullopt;
    return Opened{*header, sealed.subspan(kHeaderBytes)};
  }

 private:
  SessionId session_;
  uint64_t send_seed_;
  uint64_t receive_seed_;
  uint64_t sent_ = 0;
  ReplayWindow window_;
};

}  // namespace

std::unique_ptr<Seal> make_clear_seal(SessionId session, const Bytes16& key, Side side) {
  return std::make_unique<ClearSeal>(session, key, side);
}

}  // namespace gnomon::protocol
