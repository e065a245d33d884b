#include "protocol/seal.h"

#include <cassert>

namespace gnomon::protocol {
namespace {

static_assert(kTagBytes == Aead::kTagBytes);

// The integrity limit: wrong tags after which nothing more is opened. RFC 9001 (6.6) has 2^36 for ChaCha20-Poly1305 and
// more for AES-GCM.
constexpr uint64_t kMaxForged = uint64_t{1} << 36;

}  // namespace

SealState first_state(const SealSecrets& secrets, Side side) {
  SealState state;
  state.sending.by_parity[0] = side == Side::client ? secrets.client : secrets.server;
  state.receiving.by_parity[0] = side == Side::client ? secrets.server : secrets.client;
  return state;
}

Seal::Seal(SessionId session, CipherId cipher, SealState& state, Side side, uint64_t epoch_datagrams)
    : session_(session),
      epoch_datagrams_(epoch_datagrams),
      state_(state),
      sending_(cipher, state.sending, true),
      receiving_(cipher, state.receiving, false),
      window_(state.opened),
      text_(side == Side::client ? kMaxProbedBytes : kMaxDatagramBytes) {}

Seal::Seal(SessionId session, CipherId cipher, const SealSecrets& secrets, Side side, uint64_t epoch_datagrams)
    : session_(session),
      epoch_datagrams_(epoch_datagrams),
      own_(first_state(secrets, side)),
      state_(own_),
      sending_(cipher, own_.sending, true),
      receiving_(cipher, own_.receiving, false),
      text_(side == Side::client ? kMaxProbedBytes : kMaxDatagramBytes) {}

Seal::~Seal() { wipe(&own_, sizeof own_); }

uint64_t Seal::skip() {
  const uint64_t sequence = ++state_.sent;
  if (sequence / epoch_datagrams_ != state_.sending.epoch) begin(sending_, sequence);
  return sequence;
}

void Seal::pass(uint64_t sequence) {
  if (sequence / epoch_datagrams_ != state_.receiving.epoch) begin(receiving_, sequence);
}

// Begins the epoch of `sequence` if that is the next one.
void Seal::begin(SealKeys& keys, uint64_t sequence) {
  const uint64_t epoch = sequence / epoch_datagrams_;
  if (keys.of(epoch)) keys.begin(epoch);
}

uint64_t Seal::seal(DatagramKind kind, std::span<const uint8_t> body, std::span<uint8_t> out) {
  assert(out.size() == sealed_size(body.size()));
  const uint64_t sequence = skip();
  Aead& aead = *sending_.of(sequence / epoch_datagrams_);
  write_header(out.first<kHeaderBytes>(), {.kind = kind, .flags = 0, .session = session_, .sequence = sequence});
  aead.seal(sequence, out.first(kHeaderBytes), body, out.data() + kHeaderBytes);
  return sequence;
}

uint64_t Seal::seal(DatagramKind kind, std::span<const uint8_t> body, std::vector<uint8_t>& datagram) {
  datagram.resize(sealed_size(body.size()));
  return seal(kind, body, std::span(datagram));
}

std::optional<Opened> Seal::open(std::span<const uint8_t> datagram) {
  if (datagram.size() < sealed_size(0) || datagram.size() > text_.size()) return reject(Rejection::header);
  const auto header = decode_header(datagram);
  if (!header) return reject(Rejection::header);
  if (header->session != session_) return reject(Rejection::session);
  if (!window_.is_new(header->sequence)) return reject(Rejection::replayed);
  const uint64_t epoch = header->sequence / epoch_datagrams_;
  Aead* const aead = receiving_.of(epoch);
  if (!aead) return reject(Rejection::replayed);
  const auto sealed = datagram.subspan(kHeaderBytes);
  if (forged_ >= kMaxForged || !aead->open(header->sequence, datagram.first(kHeaderBytes), sealed, text_.data())) {
    ++forged_;
    return reject(Rejection::forged);
  }
  receiving_.begin(epoch);
  window_.take(header->sequence);
  state_.opened = window_.newest();
  return Opened{*header, std::span(text_).first(sealed.size() - kTagBytes)};
}

std::optional<Opened> Seal::reject(Rejection why) {
  rejection_ = why;
  return std::nullopt;
}

}  // namespace gnomon::protocol
