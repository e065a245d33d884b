#include "daemon/session/resumption.h"

#include <utility>

namespace gnomon::daemon {
namespace {

template <size_t Size>
void put(std::array<char, Size>& field, const std::string& text) {
  text.copy(field.data(), Size - 1);
}

bool makes_sense(const SessionRecord& record) {
  const bool cipher =
      record.cipher == protocol::CipherId::aes_128_gcm || record.cipher == protocol::CipherId::chacha20_poly1305;
  const uint64_t epoch = record.seal.sent / protocol::kEpochDatagrams;
  const bool epochs = record.seal.sending.epoch <= epoch && epoch <= record.seal.sending.epoch + 1;
  return cipher && epochs && record.credential.kind <= Credential::Kind::certificate && is_known(record.codec) &&
         is_known(record.dense_codec) && record.rate_hz >= 0;
}

}  // namespace

SessionRecord record_of(SessionId id, const SessionGrant& grant, const std::string& tenant,
                        const SessionKeys& keys) {
  SessionRecord record{.id = id.value,
                       .features = grant.features,
                       .rate_hz = grant.rate_hz,
                       .width = grant.width,
                       .height = grant.height,
                       .codec = grant.codec,
                       .dense_codec = grant.dense_codec,
                       .cipher = grant.cipher,
                       .samples = to_byte(grant.samples),
                       .credential = grant.credential,
                       .scene_hash = keys.scene_hash,
                       .resumption = keys.resumption,
                       .seal = keys.seal};
  put(record.tenant, tenant);
  put(record.scene, grant.scene_name);
  return record;
}

std::variant<SessionGrant, protocol::Refused> grant_of(const SessionRecord& record,
                                                       const TenantDirectory& directory, const Config& config,
                                                       const FindScene& find_scene) {
  using protocol::RefusalCode;
  const auto tenant = directory.find(record.tenant.data());
  if (!tenant || !makes_sense(record)) return refusal(RefusalCode::unknown_session, "the session is over");
  protocol::Hello hello;
  hello.features = record.features;
  hello.scene = record.scene.data();
  hello.width = record.width;
  hello.height = record.height;
  hello.rate_hz = record.rate_hz;
  hello.samples = record.samples;
  auto verdict = check_hello(hello, *tenant, config, find_scene);
  if (auto* grant = std::get_if<SessionGrant>(&verdict)) {
    grant->codec = record.codec;
    grant->dense_codec = record.dense_codec;
    grant->cipher = record.cipher;
    grant->credential = record.credential;
  }
  return verdict;
}

}  // namespace gnomon::daemon
