#include "protocol/messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "tests/unit/protocol/random_messages.h"

namespace gnomon::protocol {
namespace {

using tests::kMessageTypes;
using tests::Random;
using tests::random_message;

using Bytes = std::vector<uint8_t>;
constexpr size_t kHelloType = 0, kSceneChangedType = 3, kDegradedType = 5, kDrainingType = 6,
                 kByeType = 8;  // among Message's alternatives

// Reads one message from bytes that arrive at once.
Result<std::optional<Message>> read_one(std::span<const uint8_t> bytes) {
  MessageReader reader;
  reader.feed(bytes);
  return reader.next();
}

// A message from its type and body.
Bytes frame_of(uint16_t type, std::span<const uint8_t> body) {
  const auto length = static_cast<uint32_t>(2 + body.size());
  Bytes frame(6 + body.size());
  std::memcpy(frame.data(), &length, 4);
  std::memcpy(frame.data() + 4, &type, 2);
  std::copy(body.begin(), body.end(), frame.begin() + 6);
  return frame;
}

std::span<const uint8_t> body_of(const Bytes& frame) { return std::span(frame).subspan(6); }

void expect_refused(const Message& message) {
  const auto read = read_one(encode(message));
  EXPECT_FALSE(read.has_value()) << "message of type " << message.index() + 1;
}

void expect_taken(const Message& message) {
  const auto read = read_one(encode(message));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_TRUE(read->has_value());
  EXPECT_EQ(**read, message);
}

TEST(Messages, EveryTypeComesBackAsItWas) {
  Random random(1);
  for (size_t type = 0; type < kMessageTypes; ++type) {
    for (int i = 0; i < 200; ++i) expect_taken(random_message(type, random));
  }
}

TEST(Messages, APieceOfAFrameIsNoMessageYet) {
  Random random(2);
  for (size_t type = 0; type < kMessageTypes; ++type) {
    const Bytes frame = encode(random_message(type, random));
    for (size_t size = 0; size < frame.size(); ++size) {
      const auto read = read_one(std::span(frame).first(size));
      ASSERT_TRUE(read.has_value());
      EXPECT_FALSE(read->has_value());
    }
  }
}

// Whether the first `size` bytes of the body are all but what a peer without soft shadows leaves out.
bool is_without_soft(size_t type, const Bytes& frame, size_t size) {
  const size_t left_out = body_of(frame).size() - size;
  if (type == kDegradedType) return left_out == sizeof(Degraded::samples);
  if (type == kHelloType) {
    const auto hello = std::get<Hello>(**read_one(frame));
    return (hello.features & kFeatureSoft) != 0 && left_out == sizeof(Hello::samples);
  }
  if (type != kSceneChangedType) return false;
  const auto changed = std::get<SceneChanged>(**read_one(frame));
  return left_out == 1 + 2 + 25 * changed.areas.size();
}

TEST(Messages, ABodyCutShortAnywhereIsAnError) {
  Random random(3);
  for (size_t type = 0; type < kMessageTypes; ++type) {
    for (int i = 0; i < 5; ++i) {
      const Bytes frame = encode(random_message(type, random));
      for (size_t size = 0; size < body_of(frame).size(); ++size) {
        // Those of older peers, and without soft shadows.
        if (type == kByeType && size + sizeof(Bye::stay_out_ms) == body_of(frame).size()) continue;
        if (type == kDrainingType && size + sizeof(Draining::flags) == body_of(frame).size()) continue;
        if (is_without_soft(type, frame, size)) continue;
        const Bytes cut = frame_of(static_cast<uint16_t>(type + 1), body_of(frame).first(size));
        EXPECT_FALSE(read_one(cut).has_value()) << "type " << type + 1 << ", " << size << " bytes";
      }
    }
  }
}

TEST(Messages, WhatPeersWithoutSoftShadowsLeaveOutMeansHardOnes) {
  Random random(7);
  Hello hello = std::get<Hello>(random_message(kHelloType, random));
  hello.features = kFeatureSoft;
  hello.samples = 16;
  const Bytes bytes = encode(hello);
  const auto read = read_one(frame_of(kHelloType + 1, body_of(bytes).first(body_of(bytes).size() - 1)));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(std::get<Hello>(**read).samples, 0);
  hello.features = 0;
  EXPECT_EQ(encode(hello).size() + 1, bytes.size()) << "not on the wire without the feature";
  const Degraded degraded{.width = 8, .height = 8, .rate_hz = 30, .reason = "load"};
  EXPECT_EQ(encode(degraded).size() + 1, encode(Degraded{8, 8, 30, "load", {}, 4}).size());
}

TEST(Messages, SamplesAndAreasThatMakeNoSenseAreRefused) {
  Random random(8);
  Welcome welcome = std::get<Welcome>(random_message(1, random));
  welcome.features = kFeatureSoft;
  welcome.lights_version = 0;
  welcome.motions.clear();
  welcome.data_host.clear();
  welcome.home_host.clear();
  welcome.home_port = 0;
  welcome.scene.lights.assign(2, tests::random_light(random));
  welcome.areas = {{1, {1, 0, 0}, {0, 1, 0}}, {}};
  welcome.samples = 16;
  expect_taken(welcome);
  for (const uint8_t samples : {1, 4, 16, 64 + 1, 64 + 16, 128 + 4}) {
    Welcome right = welcome;
    right.samples = samples;
    expect_taken(right);
  }
  for (const uint8_t samples : {0, 2, 8, 17, 64, 128 + 5, 192 + 4}) {
    Welcome wrong = welcome;
    wrong.samples = samples;
    expect_refused(wrong);
  }
  Welcome wrong = welcome;
  wrong.areas[0].shape = 4;
  expect_refused(wrong);
  wrong = welcome;
  wrong.areas[0].u[1] = std::numeric_limits<float>::infinity();
  expect_refused(wrong);
  wrong = welcome;
  wrong.areas.pop_back();
  expect_refused(wrong);
  expect_refused(Degraded{8, 8, 30, "load", {}, 2});
}

TEST(Messages, AByeOfAnOlderPeerLetsItsClientComeBack) {
  const Bytes frame = encode(Bye{"so long", 60'000});
  const auto older = read_one(frame_of(kByeType + 1, body_of(frame).first(body_of(frame).size() - 4)));
  ASSERT_TRUE(older.has_value()) << older.error().message;
  EXPECT_EQ(std::get<Bye>(**older), (Bye{"so long", 0}));
}

TEST(Messages, FieldsOfALaterVersionAreIgnored) {
  Random random(4);
  for (size_t type = 0; type < kMessageTypes; ++type) {
    const Message message = random_message(type, random);
    const Bytes frame = encode(message);
    Bytes body(body_of(frame).begin(), body_of(frame).end());
    body.insert(body.end(), {1, 2, 3, 4, 5});
    const auto read = read_one(frame_of(static_cast<uint16_t>(type + 1), body));
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(**read, message);
  }
}

TEST(Messages, RandomBytesGiveAMessageOrAnError) {
  Random random(5);
  size_t errors = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes body(random() % 200);
    for (uint8_t& byte : body) byte = static_cast<uint8_t>(random() % 3 == 0 ? random() : 0);
    const auto type = static_cast<uint16_t>(random() % (kMessageTypes + 3));
    errors += !read_one(frame_of(type, body)).has_value();
  }
  EXPECT_GT(errors, 5000u);
}

TEST(Messages, DamagedMessagesGiveAMessageOrAnError) {
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    Bytes frame = encode(random_message(random() % kMessageTypes, random));
    for (uint64_t flips = 1 + random() % 4; flips > 0; --flips) {
      frame[random() % frame.size()] ^= static_cast<uint8_t>(1u << random() % 8);
    }
    const auto read = read_one(frame);
    // A message that was accepted is valid: it can be encoded and read again.
    if (read.has_value() && read->has_value()) expect_taken(**read);
  }
}

TEST(Messages, SizesRatesAndVersionsThatMakeNoSenseAreRefused) {
  Random random(7);
  const auto hello = std::get<Hello>(random_message(0, random));
  const auto with = [](auto message, auto change) {
    change(message);
    expect_refused(message);
  };
  expect_taken(hello);
  with(hello, [](Hello& m) { m.version_min = static_cast<uint16_t>(m.version_max + 1); });
  with(hello, [](Hello& m) { m.width = 0; });
  with(hello, [](Hello& m) { m.height = 0; });
  with(hello, [](Hello& m) { m.border_x = m.width; });
  with(hello, [](Hello& m) { m.border_y = m.height; });
  with(hello, [](Hello& m) { m.rate_hz = -1; });
  with(hello, [](Hello& m) { m.rate_hz = NAN; });
  const auto welcome = std::get<Welcome>(random_message(1, random));
  with(welcome, [](Welcome& m) { m.data_port = 0; });
  with(welcome, [](Welcome& m) { m.width = 0; });
  with(welcome, [](Welcome& m) { m.height = kMaxSide + 1; });
  with(welcome, [](Welcome& m) { m.rate_hz = INFINITY; });
  with(welcome, [](Welcome& m) { m.codec = static_cast<CodecId>(7); });
  with(welcome, [](Welcome& m) { m.scene.bounds_max[1] = NAN; });
  with(welcome, [](Welcome& m) { m.scene.default_camera.orientation = {0, 0, 0, 0.9f}; });
  with(Refused{}, [](Refused& m) { m.fit_rate_hz = -INFINITY; });
  with(Degraded{8, 8, 1, "", {}}, [](Degraded& m) { m.height = 0; });
}

TEST(Messages, LightsThatMakeNoSenseAreRefused) {
  Random random(8);
  LightInfo spot = tests::random_light(random);
  spot.kind = LightKind::spot;
  expect_taken(LightsChanged{{spot}});
  const std::vector<std::function<void(LightInfo&)>> changes = {
      [](LightInfo& l) { l.kind = static_cast<LightKind>(3); },
      [](LightInfo& l) { l.position[0] = NAN; },
      [](LightInfo& l) {
        l.direction = {0, 0, 0};
      },
      [](LightInfo& l) { l.direction[2] += 0.5f; },
      [](LightInfo& l) { l.color[1] = INFINITY; },
      [](LightInfo& l) { l.intensity = -1; },
      [](LightInfo& l) { l.range = NAN; },
      [](LightInfo& l) { l.inner_cone_cos = 1.5f; },
      [](LightInfo& l) { l.outer_cone_cos = NAN; },
  };
  for (const auto& change : changes) {
    LightInfo light = spot;
    change(light);
    expect_refused(LightsChanged{{light}});
  }
  LightInfo point = spot;  // whose direction means nothing
  point.kind = LightKind::point;
  point.direction = {0, 0, 0};
  expect_taken(LightsChanged{{point}});
}

TEST(Messages, TextsAndListsAreBoundedOnBothSides) {
  EXPECT_EQ(std::get<Bye>(**read_one(encode(Bye{std::string(5000, 'x')}))).reason, std::string(1024, 'x'));
  Random random(9);
  const LightsChanged many{std::vector<LightInfo>(300, tests::random_light(random))};
  EXPECT_EQ(std::get<LightsChanged>(**read_one(encode(many))).lights.size(), kMaxLights);
  Bytes body = {0x01, 0x04};  // a text of 1,025 bytes
  body.resize(2 + 1025, 'x');
  EXPECT_FALSE(read_one(frame_of(9, body)).has_value());
  EXPECT_FALSE(read_one(frame_of(9, Bytes{2, 0, 'a', '\n'})).has_value());
  EXPECT_FALSE(read_one(frame_of(9, Bytes{2, 0, 0xc3, 'a'})).has_value());
  EXPECT_FALSE(read_one(frame_of(5, Bytes{0xff, 0xff})).has_value());
}

TEST(Messages, CodecsThatAServerDoesNotKnowArePassedOver) {
  Random random(10);
  auto hello = std::get<Hello>(random_message(0, random));
  hello.codecs = {static_cast<CodecId>(200), CodecId::raw32_lz4, static_cast<CodecId>(2), CodecId::tiles_lz4};
  const auto read = read_one(encode(hello));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(std::get<Hello>(**read).codecs, (std::vector{CodecId::raw32_lz4, CodecId::tiles_lz4}));
}

TEST(MessageReader, TakesAStreamInPiecesOfAnySize) {
  Random random(11);
  std::vector<Message> sent;
  Bytes stream;
  for (int i = 0; i < 300; ++i) {
    sent.push_back(random_message(random() % kMessageTypes, random));
    const Bytes frame = encode(sent.back());
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  for (const size_t largest_piece : {size_t{1}, size_t{7}, size_t{1000}, stream.size()}) {
    MessageReader reader;
    std::vector<Message> received;
    for (size_t at = 0; at < stream.size();) {
      const size_t piece = std::min(stream.size() - at, 1 + random() % largest_piece);
      reader.feed(std::span(stream).subspan(at, piece));
      at += piece;
      for (auto next = reader.next(); next.has_value() && next->has_value(); next = reader.next()) {
        received.push_back(**next);
      }
    }
    EXPECT_EQ(received, sent);
  }
}

TEST(MessageReader, SkipsUnknownTypes) {
  MessageReader reader;
  for (const uint16_t type : {uint16_t{0}, uint16_t{kMessageTypes + 1}, uint16_t{65535}}) {
    reader.feed(frame_of(type, Bytes(100, 0xee)));
    reader.feed(frame_of(type, Bytes{}));
  }
  reader.feed(encode(Draining{42}));
  const auto next = reader.next();
  ASSERT_TRUE(next.has_value());
  ASSERT_TRUE(next->has_value());
  EXPECT_EQ(**next, Message{Draining{42}});
}

TEST(MessageReader, RefusesALengthBeforeItsBytesHaveCome) {
  for (const uint32_t length : {0u, 1u, 997u, 0xffffffffu}) {
    MessageReader reader(1000);
    Bytes bytes(4);
    std::memcpy(bytes.data(), &length, 4);
    reader.feed(bytes);
    EXPECT_FALSE(reader.next().has_value()) << length;
  }
  MessageReader reader(1000);
  reader.feed(frame_of(77, Bytes(994)));  // a frame of just 1,000 bytes
  EXPECT_TRUE(reader.next().has_value());
}

TEST(MessageReader, AnErrorIsFinal) {
  MessageReader reader;
  reader.feed(frame_of(9, Bytes{}));
  const auto first = reader.next();
  ASSERT_FALSE(first.has_value());
  reader.feed(encode(Draining{1}));
  const auto second = reader.next();
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().message, first.error().message);
}

TEST(RefusalCodes, HaveDistinctNames) {
  std::vector<std::string> names;
  for (uint16_t code = 1; code <= 14; ++code) names.emplace_back(to_string(static_cast<RefusalCode>(code)));
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
  EXPECT_STREQ(to_string(static_cast<RefusalCode>(15)), "unknown");
}

}  // namespace
}  // namespace gnomon::protocol
