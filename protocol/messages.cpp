#include "protocol/messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/sample_counts.h"
#include "protocol/fields.h"

namespace gnomon::protocol {
namespace {

// WIRE.md's limits of texts (bytes) and lists (items), beside those of messages.h.
constexpr size_t kMaxSentence = 1024;
constexpr size_t kMaxCiphers = 16;
constexpr size_t kMaxCodecs = 16;
constexpr size_t kMaxPasses = 32;
constexpr size_t kMaxMotions = 256;
constexpr size_t kMaxTicket = 64;
constexpr size_t kMaxHashes = 4;

constexpr size_t kLengthBytes = 4;
constexpr size_t kTypeBytes = 2;

bool is_rate(float hz) { return std::isfinite(hz) && hz >= 0; }
bool is_side(uint16_t pixels) { return pixels > 0 && pixels <= kMaxSide; }
bool is_known(CipherId cipher) { return cipher == CipherId::aes_128_gcm || cipher == CipherId::chacha20_poly1305; }

template <class A>
void fields(A& a, Of<A, LightInfo>& m) {
  a(m.kind, m.position, m.direction, m.color, m.intensity, m.range, m.inner_cone_cos, m.outer_cone_cos);
  a.check(is_valid(m), "a light is of unknown kind, not finite, negative or not of unit direction");
}

template <class A>
void lights(A& a, Of<A, std::vector<LightInfo>>& list) {
  a.list(list, kMaxLights, [&](auto& light) { fields(a, light); });
}

template <class A>
void passes(A& a, Of<A, std::vector<std::string>>& list) {
  a.list(list, kMaxPasses, [&](auto& pass) { a.text(pass, kMaxName); });
}

template <class A>
void fields(A& a, Of<A, SceneManifest>& m) {
  a.text(m.name, kMaxScene);
  a(m.content_hash, m.triangles, m.bounds_min, m.bounds_max);
  for (size_t axis = 0; axis < 3; ++axis) {
    a.check(std::isfinite(m.bounds_min[axis]) && std::isfinite(m.bounds_max[axis]), "bounds are not finite");
  }
  fields(a, m.default_camera);
  lights(a, m.lights);
}

// What a message says of soft shadows, of a scene with `light_count` lights.
template <class A>
void soft(A& a, Of<A, uint8_t>& samples, Of<A, std::vector<AreaInfo>>& areas, size_t light_count) {
  a(samples);
  a.check(is_valid(sample_counts_of(samples)), "samples other than 1, 4 or 16, or of unknown occlusion");
  a.list(areas, kMaxLights, [&](auto& area) {
    a(area.shape, area.u, area.v);
    a.check(is_valid(area), "an area is of unknown shape or not finite");
  });
  a.check(areas.size() == light_count, "areas of another number of lights");
}

template <class A>
void fields(A& a, Of<A, NodeMotion>& m) {
  a.text(m.node, kMaxName);
  a(m.kind, m.vector, m.period_us);
  const bool finite = std::isfinite(m.vector[0]) && std::isfinite(m.vector[1]) && std::isfinite(m.vector[2]);
  a.check(m.kind <= 1 && finite && m.period_us > 0, "a motion is of unknown kind, not finite or without time");
}

// A list of identifiers in order of preference. Reading drops unknown ones, which a newer client may list.
template <class A, class Id>
void preferences(A& a, Id& list, size_t max_count) {
  a.list(list, max_count, [&](auto& id) { a(id); });
  if constexpr (A::kReading) std::erase_if(list, [](auto id) { return !is_known(id); });
}

template <class A>
void fields(A& a, Of<A, Hello>& m) {
  a(m.version_min, m.version_max, m.features);
  a.check(m.version_min <= m.version_max, "version_min is above version_max");
  // The rest has the layout of a version that this side does not speak; the server refuses such a Hello.
  if (A::kReading && (kVersion < m.version_min || kVersion > m.version_max)) return;
  a.text(m.client, kMaxName);
  a.text(m.tenant, kMaxName);
  a.text(m.token, kMaxToken);
  preferences(a, m.ciphers, kMaxCiphers);
  a.text(m.scene, kMaxScene);
  a(m.width, m.height, m.border_x, m.border_y, m.rate_hz);
  // A size that is merely too large is not malformed: the server refuses it and offers one that fits.
  a.check(m.width > 0 && m.height > 0, "the size is empty");
  a.check(m.border_x < m.width && m.border_y < m.height, "the border leaves no picture");
  a.check(is_rate(m.rate_hz), "the rate is negative or not finite");
  preferences(a, m.codecs, kMaxCodecs);
  passes(a, m.passes);
  if ((m.features & kFeatureSoft) == 0) return;
  if constexpr (A::kReading) {
    if (a.rest().empty()) return;  // hard shadows will do
  }
  a(m.samples);
}

template <class A>
void fields(A& a, Of<A, Welcome>& m) {
  a(m.version, m.features, m.session, m.data_port, m.cipher, m.width, m.height, m.rate_hz, m.codec);
  a.check(m.data_port != 0, "the data port is 0");
  a.check(is_side(m.width) && is_side(m.height), "the size is empty or too large");
  a.check(is_rate(m.rate_hz), "the rate is negative or not finite");
  a.check(is_known(m.cipher), "the cipher is unknown");
  a.check(is_known(m.codec), "the codec is unknown");
  passes(a, m.passes);
  a.text(m.tracer, kMaxName);
  a(m.silence_timeout_ms);
  fields(a, m.scene);
  if (m.features & kFeatureMoments) {
    a(m.lights_version);
    a.list(m.motions, kMaxMotions, [&](auto& motion) { fields(a, motion); });
  }
  if (m.features & kFeatureFleet) {
    a.text(m.data_host, kMaxName);
    a.text(m.home_host, kMaxName);
    a(m.home_port);
    a.check(m.home_port != 0, "the home port is 0");
  }
  if (m.features & kFeatureSoft) soft(a, m.samples, m.areas, m.scene.lights.size());
}

template <class A>
void fields(A& a, Of<A, Refused>& m) {
  a(m.code);
  a.text(m.text, kMaxSentence);
  a(m.fit_width, m.fit_height, m.fit_rate_hz);
  a.check(is_rate(m.fit_rate_hz), "the rate is negative or not finite");
}

template <class A>
void fields(A& a, Of<A, SceneChanged>& m) {
  fields(a, m.scene);
  if constexpr (A::kReading) {
    if (a.rest().empty()) return;  // without kFeatureSoft
  } else if (m.samples == 0) {
    return;
  }
  soft(a, m.samples, m.areas, m.scene.lights.size());
}

template <class A>
void fields(A& a, Of<A, LightsChanged>& m) {
  lights(a, m.lights);
  a(m.version);
}

template <class A>
void fields(A& a, Of<A, Degraded>& m) {
  a(m.width, m.height, m.rate_hz);
  a.check(is_side(m.width) && is_side(m.height), "the size is empty or too large");
  a.check(is_rate(m.rate_hz), "the rate is negative or not finite");
  a.text(m.reason, kMaxSentence);
  a.list(m.untraced_lights, kMaxLights, [&](auto& light) { a(light); });
  if constexpr (A::kReading) {
    if (a.rest().empty()) return;  // without kFeatureSoft
  } else if (m.samples == 0) {
    return;
  }
  a(m.samples);
  a.check(is_valid(sample_counts_of(m.samples)), "samples other than 1, 4 or 16, or of unknown occlusion");
}

template <class A>
void fields(A& a, Of<A, Draining>& m) {
  a(m.deadline_ms);
  if constexpr (A::kReading) {
    if (a.rest().empty()) return;  // of a peer that does not know the rest
  }
  a(m.flags);
}

template <class A>
void fields(A& a, Of<A, Stats>& m) {
  a(m.frames, m.coalesced, m.queue_us, m.gpu_us, m.total_us);
}

template <class A>
void fields(A& a, Of<A, Bye>& m) {
  a.text(m.reason, kMaxSentence);
  if constexpr (A::kReading) {
    if (a.rest().empty()) return;  // of a peer that does not know the rest
  }
  a(m.stay_out_ms);
}

template <class A>
void fields(A& a, Of<A, Data>& m) {
  a(m.kind, m.sequence);
  a.bytes(m.body, kMaxDataBytes);
}

template <class A>
void fields(A& a, Of<A, Resume>& m) {
  a(m.session, m.proof);
}

template <class A>
void fields(A& a, Of<A, Waiting>& m) {
  a.text(m.text, kMaxSentence);
  a(m.percent);
  a.check(m.percent <= 100 || m.percent == Waiting::kUnknown, "more than all of it is done");
}

template <class A>
void fields(A& a, Of<A, WebTransport>& m) {
  a(m.port);
  a.check(m.port != 0, "the port is 0");
  a.text(m.ticket, kMaxTicket);
  a.list(m.hashes, kMaxHashes, [&](auto& hash) { a(hash); });
}

// A message's type on the wire is its index in the variant, counted from 1.
constexpr std::array<const char*, std::variant_size_v<Message>> kNames = {
    "Hello", "Welcome", "Refused", "SceneChanged", "LightsChanged", "Degraded",    "Draining",
    "Stats", "Bye",     "Data",    "Resume",       "Waiting",       "WebTransport"};

template <size_t Index>
Result<Message> decode_as(std::span<const uint8_t> body) {
  Message message{std::in_place_index<Index>};
  Reader reader(body);
  fields(reader, std::get<Index>(message));
  if (!reader.ok()) return Error{std::string("malformed ") + kNames[Index] + ": " + reader.why()};
  return message;
}

using Decode = Result<Message> (*)(std::span<const uint8_t>);

template <size_t... Indices>
constexpr std::array<Decode, sizeof...(Indices)> decoders(std::index_sequence<Indices...>) {
  return {decode_as<Indices>...};
}

constexpr auto kDecoders = decoders(std::make_index_sequence<std::variant_size_v<Message>>());

template <class T>
T load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

}  // namespace

const char* to_string(RefusalCode code) {
  switch (code) {
    case RefusalCode::malformed: return "malformed";
    case RefusalCode::version: return "version";
    case RefusalCode::unknown_tenant: return "unknown_tenant";
    case RefusalCode::bad_token: return "bad_token";
    case RefusalCode::unknown_scene: return "unknown_scene";
    case RefusalCode::scene_unavailable: return "scene_unavailable";
    case RefusalCode::bad_size: return "bad_size";
    case RefusalCode::too_many_sessions: return "too_many_sessions";
    case RefusalCode::over_capacity: return "over_capacity";
    case RefusalCode::unknown_pass: return "unknown_pass";
    case RefusalCode::draining: return "draining";
    case RefusalCode::internal: return "internal";
    case RefusalCode::unknown_session: return "unknown_session";
    case RefusalCode::kept_out: return "kept_out";
  }
  return "unknown";
}

std::vector<uint8_t> encode(const Message& message) {
  std::vector<uint8_t> frame(kLengthBytes);
  Writer writer(frame);
  writer(static_cast<uint16_t>(message.index() + 1));
  std::visit([&](const auto& m) { fields(writer, m); }, message);
  const auto length = static_cast<uint32_t>(frame.size() - kLengthBytes);
  std::memcpy(frame.data(), &length, sizeof length);
  return frame;
}

void MessageReader::feed(std::span<const uint8_t> bytes) {
  if (failed_) return;
  // Moving the rest only when it is the smaller part keeps the amortised cost per byte constant.
  if (read_ > buffer_.size() / 2) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(read_));
    read_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<Message>> MessageReader::next() {
  if (failed_) return *failed_;
  while (buffer_.size() - read_ >= kLengthBytes) {
    const auto length = load<uint32_t>(buffer_.data() + read_);
    if (length < kTypeBytes) return fail("a message of " + std::to_string(length) + " bytes has no type");
    if (length > max_bytes_ - std::min(max_bytes_, kLengthBytes)) {
      return fail("a message of " + std::to_string(length) + " bytes, more than are taken here");
    }
    if (buffer_.size() - read_ - kLengthBytes < length) break;
    const uint8_t* start = buffer_.data() + read_ + kLengthBytes;
    read_ += kLengthBytes + length;
    const size_t type = load<uint16_t>(start);
    if (type == 0 || type > kDecoders.size()) continue;
    auto message = kDecoders[type - 1]({start + kTypeBytes, length - kTypeBytes});
    if (!message) return fail(message.error().message);
    return std::optional<Message>(*std::move(message));
  }
  return std::optional<Message>();
}

Error MessageReader::fail(std::string why) {
  buffer_.clear();
  read_ = 0;
  failed_ = Error{std::move(why)};
  return *failed_;
}

}  // namespace gnomon::protocol
