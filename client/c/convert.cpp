#include "client/c/convert.h"

#include <algorithm>
#include <cmath>

#include "protocol/messages.h"
#include "protocol/text.h"

namespace gnomon::client::c {
namespace {

std::string text_of(const char* text) { return text ? text : ""; }

Result<uint16_t> traced(const char* name, uint32_t shown, uint32_t border) {
  const uint64_t pixels = uint64_t{shown} + border;
  if (shown > 0 && pixels <= protocol::kMaxSide) return static_cast<uint16_t>(pixels);
  return Error{std::string(name) + ": with its border it is " + std::to_string(pixels) + " pixels; allowed: 1 to " +
               std::to_string(protocol::kMaxSide) + ", of which one is shown"};
}

Result<Transport> to_transport(gnomon_transport transport) {
  switch (transport) {
    case GNOMON_TRANSPORT_AUTO: return Transport::automatic;
    case GNOMON_TRANSPORT_UDP: return Transport::udp;
    case GNOMON_TRANSPORT_TCP: return Transport::tcp;
  }
  return Error{"transport: there is no number " + std::to_string(static_cast<int>(transport))};
}

// A text that would be sent otherwise than it was given could name another scene, or no token.
Result<void> check_text(const char* name, const std::string& text, size_t most) {
  if (text.size() > most)
    return Error{std::string(name) + ": it has " + std::to_string(text.size()) +
                 " bytes; allowed: " + std::to_string(most)};
  if (!protocol::is_wire_text(text))
    return Error{std::string(name) + ": it is not UTF-8 or has control characters"};
  return {};
}

Result<protocol::Hello> to_hello(const gnomon_options& options) {
  protocol::Hello hello;
  hello.client = options.program ? options.program : "libgnomon " GNOMON_VERSION_TEXT;
  hello.tenant = text_of(options.tenant);
  hello.token = text_of(options.token);
  hello.scene = text_of(options.scene);
  if (hello.scene.empty()) return Error{"scene: none is given"};
  if (auto fits = check_text("program", hello.client, protocol::kMaxName); !fits) return fits.error();
  if (auto fits = check_text("tenant", hello.tenant, protocol::kMaxName); !fits) return fits.error();
  if (auto fits = check_text("token", hello.token, protocol::kMaxToken); !fits) return fits.error();
  if (auto fits = check_text("scene", hello.scene, protocol::kMaxScene); !fits) return fits.error();
  const auto width = traced("width", options.width, options.border_x);
  if (!width) return width.error();
  const auto height = traced("height", options.height, options.border_y);
  if (!height) return height.error();
  hello.width = *width;
  hello.height = *height;
  hello.border_x = static_cast<uint16_t>(options.border_x);
  hello.border_y = static_cast<uint16_t>(options.border_y);
  if (!std::isfinite(options.rate_hz) || options.rate_hz < 0) return Error{"rate_hz: it is no rate"};
  hello.rate_hz = options.rate_hz;
  if (options.codec) {
    const auto codec = protocol::parse_codec(options.codec);
    if (!codec) return codec.error();
    hello.codecs = {*codec};
  }
  return hello;
}

}  // namespace

protocol::CameraView to_camera(const gnomon_camera& camera) {
  protocol::CameraView view;
  std::copy_n(camera.position, 3, view.position.begin());
  std::copy_n(camera.orientation, 4, view.orientation.begin());
  view.tan_left = camera.tan_left;
  view.tan_right = camera.tan_right;
  view.tan_up = camera.tan_up;
  view.tan_down = camera.tan_down;
  view.near_plane = camera.near_plane;
  return view;
}

gnomon_camera to_c(const protocol::CameraView& view) {
  gnomon_camera camera{};
  std::copy(view.position.begin(), view.position.end(), camera.position);
  std::copy(view.orientation.begin(), view.orientation.end(), camera.orientation);
  camera.tan_left = view.tan_left;
  camera.tan_right = view.tan_right;
  camera.tan_up = view.tan_up;
  camera.tan_down = view.tan_down;
  camera.near_plane = view.near_plane;
  return camera;
}

gnomon_light to_c(const protocol::LightInfo& light) {
  gnomon_light out{};
  out.kind = static_cast<gnomon_light_kind>(light.kind);
  std::copy(light.position.begin(), light.position.end(), out.position);
  std::copy(light.direction.begin(), light.direction.end(), out.direction);
  std::copy(light.color.begin(), light.color.end(), out.color);
  out.intensity = light.intensity;
  out.range = light.range;
  out.inner_cone_cos = light.inner_cone_cos;
  out.outer_cone_cos = light.outer_cone_cos;
  return out;
}

gnomon_motion to_c(const protocol::NodeMotion& motion) {
  gnomon_motion out{};
  out.node = motion.node.c_str();
  out.kind = static_cast<gnomon_motion_kind>(motion.kind);
  std::copy(motion.vector.begin(), motion.vector.end(), out.vector);
  out.period_us = motion.period_us;
  return out;
}

Result<ThinClientOptions> to_options(const gnomon_options& options) {
  ThinClientOptions made;
  made.mode = Mode::queued;  // the engine chooses what to show: every answer is handed on
  made.reconnect = (options.flags & GNOMON_STAY_LOST) == 0;
  if (options.flags & ~GNOMON_STAY_LOST) return Error{"flags: there are no such ones"};
  ConnectOptions& connect = made.stream.connect;
  if (!options.server) return Error{"server: none is given"};
  const auto server = parse_address(options.server);
  if (!server) return Error{"server: " + server.error().message};
  connect.server = *server;
  connect.trust = {.pin = text_of(options.pin),
                   .authorities = text_of(options.authorities),
                   .certificate = text_of(options.certificate),
                   .key = text_of(options.key),
                   .fleet = text_of(options.fleet)};
  if (connect.trust.certificate.empty() != connect.trust.key.empty())
    return Error{connect.trust.key.empty() ? "key: none is given for the certificate"
                                           : "certificate: none is given for the key"};
  const auto transport = to_transport(options.transport);
  if (!transport) return transport.error();
  connect.transport = *transport;
  auto hello = to_hello(options);
  if (!hello) return hello.error();
  connect.hello = std::move(*hello);
  const uint32_t samples = std::max(options.samples, 1u);
  if (!is_sample_count(samples)) return Error{"samples: 1, 4 or 16"};
  const auto occlusion = static_cast<uint32_t>(options.occlusion);
  if (occlusion > GNOMON_OCCLUSION_FULL) return Error{"occlusion: there is no such one"};
  made.stream.samples = {samples, static_cast<Occlusion>(occlusion)};
  if (options.open_timeout_ms > 0) connect.timeout = std::chrono::milliseconds(options.open_timeout_ms);
  return made;
}

}  // namespace gnomon::client::c
