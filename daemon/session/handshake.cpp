#include "daemon/session/handshake.h"

#include <algorithm>
#include <optional>

#include "daemon/config/render_effects.h"
#include "protocol/seal_keys.h"

namespace gnomon::daemon {
namespace {

using protocol::Hello;
using protocol::RefusalCode;
using protocol::Refused;

constexpr uint64_t kFeatures = protocol::kFeatureMoments | protocol::kFeatureFeedback | protocol::kFeatureParity |
                               protocol::kFeatureReferences | protocol::kFeatureResume | protocol::kFeatureSizes |
                               protocol::kFeaturePaths | protocol::kFeatureWaiting | protocol::kFeatureSoft;

// Those that this server has.
uint64_t features_of(const Config& config) {
  return kFeatures | (config.web.webtransport ? protocol::kFeatureWebTransport : 0) |
         (config.server.public_address.empty() ? 0 : protocol::kFeatureFleet);
}

// Camera updates a second of one session. Beyond it no display shows more, and sums of rates stay exact.
constexpr float kLeastRateHz = 0.01f, kMostRateHz = 1000;

// 0, if none was named.
float granted_rate(float asked_hz) { return asked_hz > 0 ? std::clamp(asked_hz, kLeastRateHz, kMostRateHz) : 0; }

// Text from a client, quoted and cut to 80 bytes.
std::string shown(const std::string& text) {
  std::string quoted(1, '\'');
  return quoted.append(text, 0, 80).append(1, '\'');
}

std::optional<Refused> check_features(const Hello& hello, const ServerConfig& server) {
  if (!server.require_path_validation || (hello.features & protocol::kFeaturePaths) != 0) return std::nullopt;
  return refusal(RefusalCode::version, "this server serves clients with the feature paths (bit 6) alone");
}

std::optional<Refused> check_size(const Hello& hello, const RenderConfig& render) {
  const bool inside =
      hello.width >= 1 && hello.width <= render.max_width && hello.height >= 1 && hello.height <= render.max_height;
  const bool border_inside = hello.border_x < hello.width && hello.border_y < hello.height;
  if (inside && border_inside) return std::nullopt;
  Refused refused = refusal(RefusalCode::bad_size, "");
  refused.fit_width = std::clamp<uint16_t>(hello.width, 1, render.max_width);
  refused.fit_height = std::clamp<uint16_t>(hello.height, 1, render.max_height);
  refused.text = inside ? "the prediction border must be smaller than the buffer"
                        : "the buffer may be 1x1 to " + std::to_string(render.max_width) + "x" +
                              std::to_string(render.max_height) + " pixels";
  return refused;
}

// The server chooses which passes run; a client may require passes, which must be among them.
std::optional<Refused> check_passes(const Hello& hello, const RenderConfig& render) {
  for (const std::string& pass : hello.passes) {
    if (offers(render, pass)) continue;
    std::string offered;
    for (const std::string& name : effects_of(render)) offered += (offered.empty() ? "" : ", ") + name;
    return refusal(RefusalCode::unknown_pass, "no pass " + shown(pass) + " here; there are: " + offered);
  }
  return std::nullopt;
}

// The client's first choice. If it names none, the configured codec, unless that is tiles_context and the client does
// not support references: then tiles_lz4.
protocol::CodecId choose_codec(const Hello& hello, const EncodeConfig& encode) {
  if (!hello.codecs.empty()) return hello.codecs.front();
  const bool context = (hello.features & protocol::kFeatureReferences) != 0;
  return encode.codec == protocol::CodecId::tiles_context && !context ? protocol::CodecId::tiles_lz4 : encode.codec;
}

// The densest codec that the client decodes. Codecs are numbered by density.
protocol::CodecId densest_codec(const Hello& hello, const EncodeConfig& encode) {
  if ((hello.features & protocol::kFeatureReferences) != 0) return protocol::CodecId::tiles_context;
  if (hello.codecs.empty()) return choose_codec(hello, encode);
  return *std::max_element(hello.codecs.begin(), hello.codecs.end());
}

// Of those that there are, the most that the client wants and the server allows.
SampleCounts choose_samples(const Hello& hello, const RenderConfig& render) {
  if ((hello.features & protocol::kFeatureSoft) == 0) return {};
  const SampleCounts samples = fewest(sample_counts_of(hello.samples), most_samples(render));
  return {samples.per_light >= 16 ? 16u : samples.per_light >= 4 ? 4u : 1u, samples.occlusion};
}

// The client's first choice: a client with AES instructions puts AES first. ChaCha20 also if this machine has no AES
// instructions and the client accepts it, as a server seals for many clients. Every client must support AES-128-GCM.
protocol::CipherId choose_cipher(const std::vector<protocol::CipherId>& wanted) {
  using protocol::CipherId;
  static const bool aes_is_quick = protocol::has_aes_instructions();
  if (wanted.empty()) return CipherId::aes_128_gcm;
  const bool takes_chacha = std::find(wanted.begin(), wanted.end(), CipherId::chacha20_poly1305) != wanted.end();
  return takes_chacha && !aes_is_quick ? CipherId::chacha20_poly1305 : wanted.front();
}

}  // namespace

Refused refusal(RefusalCode code, std::string text) {
  Refused refused;
  refused.code = code;
  refused.text = std::move(text);
  return refused;
}

std::optional<Refused> check_version(const Hello& hello) {
  if (protocol::kVersion >= hello.version_min && protocol::kVersion <= hello.version_max) return std::nullopt;
  return refusal(RefusalCode::version, "this server speaks version " + std::to_string(protocol::kVersion));
}

std::variant<SessionGrant, Refused> check_hello(const Hello& hello, TenantId tenant, const Config& config,
                                                const FindScene& find_scene) {
  if (auto refused = check_features(hello, config.server)) return *refused;
  if (auto refused = check_size(hello, config.render)) return *refused;
  if (auto refused = check_passes(hello, config.render)) return *refused;
  std::string scene = find_scene(hello.scene);
  if (scene.empty()) return refusal(RefusalCode::unknown_scene, "no scene " + shown(hello.scene) + " here");
  return SessionGrant{.tenant = tenant,
                      .scene_name = std::move(scene),
                      .width = hello.width,
                      .height = hello.height,
                      .rate_hz = granted_rate(hello.rate_hz),
                      .codec = choose_codec(hello, config.encode),
                      .dense_codec = densest_codec(hello, config.encode),
                      .cipher = choose_cipher(hello.ciphers),
                      .samples = choose_samples(hello, config.render),
                      .features = hello.features & features_of(config)};
}

}  // namespace gnomon::daemon
