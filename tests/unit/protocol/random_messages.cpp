#include "tests/unit/protocol/random_messages.h"

#include <cmath>

#include "common/sample_counts.h"

namespace gnomon::tests {
namespace {

using namespace protocol;

float number(Random& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

uint64_t below(Random& random, uint64_t limit) { return random() % limit; }

uint16_t side(Random& random) { return static_cast<uint16_t>(1 + below(random, kMaxSide)); }

Vec3 vector(Random& random) { return {number(random, -99, 99), number(random, -99, 99), number(random, -99, 99)}; }

template <size_t N>
std::array<float, N> unit(Random& random) {
  std::array<float, N> v;
  float squared = 0;
  do {
    squared = 0;
    for (float& component : v) {
      component = number(random, -1, 1);
      squared += component * component;
    }
  } while (squared < 0.01f);
  for (float& component : v) component /= std::sqrt(squared);
  return v;
}

Bytes16 bytes16(Random& random) {
  Bytes16 bytes;
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
  return bytes;
}

std::string text(Random& random) {
  static const char* const kCharacters[] = {"a", "Z", "7", " ", "/", "~", "é", "ß", "→", "語", "𝄞"};
  std::string out;
  for (uint64_t i = below(random, 20); i > 0; --i) out += kCharacters[below(random, std::size(kCharacters))];
  return out;
}

std::vector<std::string> texts(Random& random) {
  std::vector<std::string> out(below(random, 5));
  for (std::string& item : out) item = text(random);
  return out;
}

std::vector<LightInfo> lights(Random& random) {
  std::vector<LightInfo> out(below(random, 9));
  for (LightInfo& light : out) light = random_light(random);
  return out;
}

SceneManifest manifest(Random& random) {
  return {.name = text(random),
          .content_hash = bytes16(random),
          .triangles = random(),
          .bounds_min = vector(random),
          .bounds_max = vector(random),
          .default_camera = random_camera(random),
          .lights = lights(random)};
}

CodecId codec(Random& random) { return one_of(random, kCodecs); }
CipherId cipher(Random& random) { return static_cast<CipherId>(1 + below(random, 2)); }

Hello hello(Random& random) {
  Hello m;
  m.version_min = static_cast<uint16_t>(below(random, kVersion + 1));
  m.version_max = static_cast<uint16_t>(kVersion + below(random, 100));
  m.features = random();
  m.client = text(random);
  m.tenant = text(random);
  m.token = text(random);
  for (uint64_t i = below(random, 3); i > 0; --i) m.ciphers.push_back(cipher(random));
  m.scene = text(random);
  m.width = static_cast<uint16_t>(1 + below(random, 65535));
  m.height = static_cast<uint16_t>(1 + below(random, 65535));
  m.border_x = static_cast<uint16_t>(below(random, m.width));
  m.border_y = static_cast<uint16_t>(below(random, m.height));
  m.rate_hz = number(random, 0, 240);
  for (uint64_t i = below(random, 5); i > 0; --i) m.codecs.push_back(codec(random));
  m.passes = texts(random);
  if (m.features & kFeatureSoft) m.samples = static_cast<uint8_t>(random());
  return m;
}

uint8_t samples(Random& random) {
  return to_byte({1u << 2 * below(random, 3), static_cast<Occlusion>(below(random, 3))});
}

std::vector<AreaInfo> areas(Random& random, size_t count) {
  std::vector<AreaInfo> all(count);
  for (AreaInfo& area : all) area = {static_cast<uint8_t>(below(random, 4)), vector(random), vector(random)};
  return all;
}

SceneChanged scene_changed(Random& random) {
  SceneChanged m{manifest(random)};
  m.samples = samples(random);
  m.areas = areas(random, m.scene.lights.size());
  return m;
}

Welcome welcome(Random& random) {
  Welcome m;
  m.version = static_cast<uint16_t>(random());
  m.features = random();
  m.session = SessionId{random()};
  m.data_port = static_cast<uint16_t>(1 + below(random, 65535));
  m.cipher = cipher(random);
  m.width = side(random);
  m.height = side(random);
  m.rate_hz = number(random, 0, 240);
  m.codec = codec(random);
  m.passes = texts(random);
  m.tracer = text(random);
  m.silence_timeout_ms = static_cast<uint32_t>(random());
  m.scene = manifest(random);
  if (m.features & kFeatureMoments) {
    m.lights_version = static_cast<uint32_t>(random());
    for (uint64_t i = below(random, 4); i > 0; --i) {
      m.motions.push_back({text(random), static_cast<uint8_t>(below(random, 2)), vector(random),
                           static_cast<uint32_t>(1 + below(random, 1u << 30))});
    }
  }
  if (m.features & kFeatureFleet) {
    m.data_host = text(random);
    m.home_host = text(random);
    m.home_port = static_cast<uint16_t>(1 + below(random, 65535));
  }
  if (m.features & kFeatureSoft) {
    m.samples = samples(random);
    m.areas = areas(random, m.scene.lights.size());
  }
  return m;
}

Refused refused(Random& random) {
  return {.code = static_cast<RefusalCode>(below(random, 65536)),  // a newer server may have codes of its own
          .text = text(random),
          .fit_width = static_cast<uint16_t>(random()),
          .fit_height = static_cast<uint16_t>(random()),
          .fit_rate_hz = number(random, 0, 240)};
}

Data data(Random& random) {
  Data m{one_of(random, kDatagramKinds), random(), {}};
  for (uint64_t i = below(random, 100); i > 0; --i) m.body.push_back(static_cast<uint8_t>(random()));
  return m;
}

Stats stats(Random& random) {
  return {random(), random(), static_cast<uint32_t>(random()), static_cast<uint32_t>(random()),
          static_cast<uint32_t>(random())};
}

}  // namespace

CameraView random_camera(Random& random) {
  CameraView camera;
  camera.position = vector(random);
  camera.orientation = unit<4>(random);
  camera.tan_left = number(random, -0.4f, 2);
  camera.tan_right = number(random, 0.5f, 2);
  camera.tan_up = number(random, 0.5f, 2);
  camera.tan_down = number(random, -0.4f, 2);
  camera.near_plane = number(random, 0.001f, 1);
  return camera;
}

LightInfo random_light(Random& random) {
  return {.kind = static_cast<LightKind>(below(random, 3)),
          .position = vector(random),
          .direction = unit<3>(random),
          .color = vector(random),
          .intensity = number(random, 0, 5000),
          .range = number(random, 0, 100),
          .inner_cone_cos = number(random, -1, 1),
          .outer_cone_cos = number(random, -1, 1)};
}

CameraUpdate random_update(Random& random) {
  CameraUpdate update;
  update.frame = FrameId{static_cast<uint32_t>(random())};
  update.camera = random_camera(random);
  update.client_time_us = random();
  update.display_deadline_us = static_cast<uint32_t>(random());
  update.ack_count = static_cast<uint8_t>(below(random, kMaxAcks + 1));
  for (size_t i = 0; i < update.ack_count; ++i) {
    update.acks[i] = {FrameId{static_cast<uint32_t>(random())}, static_cast<uint16_t>(random()), random()};
  }
  return update;
}

Resume resume(Random& random) {
  Resume resume{SessionId{random()}, {}};
  for (uint8_t& byte : resume.proof) byte = static_cast<uint8_t>(random());
  return resume;
}

WebTransport web_transport(Random& random) {
  WebTransport offered{side(random), "0123456789abcdef", std::vector<Bytes32>(random() % 3)};
  for (Bytes32& hash : offered.hashes) hash.fill(static_cast<uint8_t>(random()));
  return offered;
}

Message random_message(size_t type, Random& random) {
  switch (type) {
    case 0: return hello(random);
    case 1: return welcome(random);
    case 2: return refused(random);
    case 3: return scene_changed(random);
    case 4: return LightsChanged{lights(random), static_cast<uint32_t>(random())};
    case 5:
      return Degraded{side(random),
                      side(random),
                      number(random, 0, 240),
                      text(random),
                      std::vector<uint16_t>(random() % 5, side(random)),
                      samples(random)};
    case 6: return Draining{static_cast<uint32_t>(random()), static_cast<uint8_t>(random())};
    case 7: return stats(random);
    case 8: return Bye{text(random), static_cast<uint32_t>(random())};
    case 9: return data(random);
    case 10: return resume(random);
    case 12: return web_transport(random);
    default:
      return Waiting{text(random), below(random, 3) ? static_cast<uint8_t>(below(random, 101)) : Waiting::kUnknown};
  }
}

}  // namespace gnomon::tests
