#include "daemon/session/resumption.h"

#include <algorithm>
#include <utility>

namespace gnomon::daemon {
namespace {

template <size_t Size>
void put(std::array<char, Size>& field, const std::string& text) {
  text.copy(field.data(), Size - 1);
}

bool is_known(protocol::CodecId codec) {
  return std::find(protocol::kCodecs.begin(), protocol::kCodecs.end(), codec) != protocol::kCodecs.end();
}

bool makes_sense(const SessionRecord& record) {
  const bool cipher =
      record.cipher == protocol::CipherId::aes_128_gcm || record.cipher == protocol::CipherId::chacha20_poly1305;
  const uint64_t epoch = record.seal.sent / protocol::kEpochDatagrams;
  const bool epochs = record.seal.sending.epoch <= epoch && epoch <= record.seal.sending.epoch + 1;
  return cipher && epochs && is_known(record.codec) && is_known(record.dense_codec) && record.rate_hz >= 0;
}

}  // namespace

SessionRecord record_of(SessionId id, const Accepted& accepted, const std::string& tenant,
                        const protocol::Bytes16& scene_hash, const protocol::Secret& resumption,
                        const protocol::SealState& seal) {
  SessionRecord record;
  record.id = id.value;
  record.features = accepted.features;
  record.rate_hz = accepted.rate_hz;
  record.width = accepted.width;
  record.height = accepted.height;
  record.codec = accepted.codec;
  record.dense_codec = accepted.dense_codec;
  record.cipher = accepted.cipher;
  put(record.tenant, tenant);
  put(record.scene, accepted.scene);
  record.scene_hash = scene_hash;
  record.resumption = resumption;
  record.seal = seal;
  return record;
}

std::variant<Accepted, protocol::Refused> accepted_of(const SessionRecord& record, const Roster& roster,
                                                      const Config& config, const FindScene& find_scene) {
  using protocol::RefusalCode;
  const auto tenant = roster.find(record.tenant.data());
  if (!tenant || !makes_sense(record)) return refusal(RefusalCode::unknown_session, "the session is over");
  protocol::Hello hello;
  hello.features = record.features;
  hello.scene = record.scene.data();
  hello.width = record.width;
  hello.height = record.height;
  hello.rate_hz = record.rate_hz;
  auto verdict = check_hello(hello, *tenant, config, find_scene);
  if (auto* accepted = std::get_if<Accepted>(&verdict)) {
    accepted->codec = record.codec;
    accepted->dense_codec = record.dense_codec;
    accepted->cipher = record.cipher;
  }
  return verdict;
}

}  // namespace gnomon::daemon
