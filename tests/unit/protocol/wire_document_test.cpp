// WIRE.md against the code: its worked packets byte by byte, its tables of types and codes.
#include <gtest/gtest.h>

#include <fstream>
#include <numeric>
#include <sstream>

#include "protocol/codec.h"
#include "protocol/feedback.h"
#include "protocol/messages.h"
#include "protocol/parity.h"
#include "protocol/seal.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::protocol {
namespace {

using Bytes = std::vector<uint8_t>;

const std::string& document() {
  static const std::string text = [] {
    std::ifstream file(std::string(GNOMON_SOURCE_DIR) + "/protocol/WIRE.md");
    return std::string(std::istreambuf_iterator<char>(file), {});
  }();
  return text;
}

// The bytes of the block that starts with ```hex NAME.
Bytes packet(const std::string& name) {
  const std::string begin = "```hex " + name + "\n";
  const size_t at = document().find(begin);
  if (at == std::string::npos) ADD_FAILURE() << "WIRE.md has no packet " << name;
  const size_t start = at + begin.size();
  std::istringstream lines(document().substr(start, document().find("```", start) - start));
  Bytes bytes;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream pairs(line.substr(0, line.find('#')));
    for (std::string pair; pairs >> pair;) bytes.push_back(static_cast<uint8_t>(std::stoul(pair, nullptr, 16)));
  }
  return bytes;
}

// The rows `| number | name | ...` of the table below a heading.
std::vector<std::pair<int, std::string>> numbered_rows(const std::string& heading) {
  const size_t start = document().find("\n" + heading + "\n");
  EXPECT_NE(start, std::string::npos) << heading;
  const std::string section = document().substr(start, document().find("\n##", start + 1) - start);
  std::vector<std::pair<int, std::string>> rows;
  std::istringstream lines(section);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string bar, name;
    int number = 0;
    if (cells >> bar >> number >> bar >> name) rows.emplace_back(number, name);
  }
  return rows;
}

constexpr SessionId kSession{0x1122334455667788};

// The document's secrets: 00 01 02 ... for the client, 20 21 22 ... for the server.
SealSecrets secrets() {
  SealSecrets made;
  std::iota(made.client.begin(), made.client.end(), uint8_t{0x00});
  std::iota(made.server.begin(), made.server.end(), uint8_t{0x20});
  return made;
}

std::unique_ptr<Seal> seal_of(Side side, CipherId cipher = CipherId::aes_128_gcm,
                              uint64_t epoch_datagrams = kEpochDatagrams) {
  return std::make_unique<Seal>(kSession, cipher, secrets(), side, epoch_datagrams);
}

std::string hex(std::span<const uint8_t> bytes) {
  std::string text;
  for (const uint8_t byte : bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    text.append(text.empty() ? "" : " ").append({kDigits[byte >> 4], kDigits[byte & 15]});
  }
  return text;
}

void expect_packet(const Bytes& made, const std::string& name) {
  EXPECT_EQ(hex(made), hex(packet(name))) << "WIRE.md's packet " << name;
}

// Compares the packet with the message, both written and read.
template <class M>
void expect_message(const M& message, const std::string& name) {
  expect_packet(encode(message), name);
  MessageReader reader;
  reader.feed(packet(name));
  const auto read = reader.next();
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(**read, Message{message});
}

TEST(WireDocument, HelloIsAsWorkedOut) {
  Hello hello;
  hello.client = "probe 1";
  hello.ciphers = {CipherId::aes_128_gcm};
  hello.scene = "temple";
  hello.width = 1984;
  hello.height = 1116;
  hello.border_x = 64;
  hello.border_y = 36;
  hello.rate_hz = 60;
  hello.codecs = {CodecId::tiles_lz4};
  expect_message(hello, "hello");
}

TEST(WireDocument, KeysAreAsWorkedOut) {
  const SealSecrets epoch_0 = secrets();
  const auto bytes_of = [](const Secret& secret) {
    const AeadKey key(CipherId::aes_128_gcm, secret);
    Bytes bytes(key.key().begin(), key.key().end());
    bytes.insert(bytes.end(), key.iv.begin(), key.iv.end());
    return bytes;
  };
  Bytes client = bytes_of(epoch_0.client);
  const Secret next = next_secret(epoch_0.client);
  client.insert(client.end(), next.begin(), next.end());
  expect_packet(client, "client_keys");
  expect_packet(bytes_of(epoch_0.server), "server_keys");
}

TEST(WireDocument, WelcomeIsAsWorkedOut) {
  Welcome welcome;
  welcome.features = kFeatureMoments | kFeatureFleet;
  welcome.session = kSession;
  welcome.data_port = 7600;
  welcome.width = 1280;
  welcome.height = 640;
  welcome.rate_hz = 30;
  welcome.passes = {"shadows"};
  welcome.tracer = "bvh";
  welcome.silence_timeout_ms = 5000;
  SceneManifest& scene = welcome.scene;
  scene.name = "temple";
  std::iota(scene.content_hash.begin(), scene.content_hash.end(), uint8_t{0});
  scene.triangles = 1000;
  scene.bounds_min = {-1, 0, -1};
  scene.bounds_max = {1, 2, 1};
  scene.default_camera = {{1, 1.5f, -2}, {0, 0.6f, 0, 0.8f}, 1, 1, 0.5f, 0.5f, 0.0625f};
  scene.lights = {{LightKind::spot, {0, 2, 0}, {0, -1, 0}, {1, 1, 0.5f}, 40, 8, 0.75f, 0.5f}};
  welcome.lights_version = 3;
  welcome.motions = {{"fan", 0, {0, 1, 0}, 2'000'000}};
  welcome.data_host = welcome.home_host = "192.0.2.7";
  welcome.home_port = 7600;
  expect_message(welcome, "welcome");
}

TEST(WireDocument, RefusedIsAsWorkedOut) {
  expect_message(Refused{RefusalCode::over_capacity, "full", 640, 320, 15}, "refused");
  expect_message(Bye{"too far", 60'000}, "bye");
}

TEST(WireDocument, WebTransportIsAsWorkedOut) {
  WebTransport offered{7600, "ticket001", {Bytes32{}}};
  std::iota(offered.hashes[0].begin(), offered.hashes[0].end(), uint8_t{0});
  expect_message(offered, "webtransport");
}

TEST(WireDocument, DegradedIsAsWorkedOut) { expect_message(Degraded{640, 320, 30, "load", {3}, 4}, "degraded"); }

TEST(WireDocument, DrainingIsAsWorkedOut) { expect_message(Draining{40'000, Draining::kMoveNow}, "draining"); }

TEST(WireDocument, WaitingIsAsWorkedOut) { expect_message(Waiting{"reading the scene", 40}, "waiting"); }

Bytes camera_update_body() {
  CameraUpdate update;
  update.frame = FrameId{7};
  update.camera = {{1, 1.5f, -2}, {0, 0.6f, 0, 0.8f}, 0.75f, 0.75f, 0.5f, 0.5f, 0.0625f};
  update.client_time_us = 1'000'000;
  update.display_deadline_us = 50'000;
  update.ack_count = 1;
  update.acks[0] = {FrameId{6}, 0, 0b111};
  Bytes body;
  append_camera_update(body, update);
  return body;
}

TEST(WireDocument, CameraUpdateIsAsWorkedOut) {
  const Bytes body = camera_update_body();
  expect_packet(body, "camera_update_body");
  for (const auto& [cipher, name] : {std::pair(CipherId::aes_128_gcm, "camera_update"),
                                     std::pair(CipherId::chacha20_poly1305, "camera_update_chacha")}) {
    Bytes datagram;
    seal_of(Side::client, cipher)->seal(DatagramKind::camera_update, body, datagram);
    expect_packet(datagram, name);
    const auto server = seal_of(Side::server, cipher);
    const auto opened = server->open(packet(name));
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->header, (Header{DatagramKind::camera_update, 0, kSession, 1}));
    EXPECT_EQ(hex(opened->body), hex(body));
  }
}

// With epochs of one datagram, the second datagram is of epoch 2, sealed with the keys of that epoch's secret.
TEST(WireDocument, TheNextEpochsKeysAreAsWorkedOut) {
  const auto client = seal_of(Side::client, CipherId::aes_128_gcm, 1);
  Bytes datagram;
  for (int i = 0; i < 2; ++i) client->seal(DatagramKind::camera_update, camera_update_body(), datagram);
  expect_packet(Bytes(datagram.end() - kTagBytes, datagram.end()), "second_epoch_tag");
}

TEST(WireDocument, FrameSliceIsAsWorkedOut) {
  const TileGrid grid{16, 8, 2};
  const std::vector<uint64_t> words = {0x00000103070f1f3f, ~uint64_t{0}, 0, 0x0000183c3c180000};
  FrameEncoder encoder;
  EncodedMask frame;
  ASSERT_TRUE(encoder.encode({grid, words}, CodecId::tiles_lz4, kMaxSlicePayloadBytes, frame).has_value());
  ASSERT_EQ(frame.slices.size(), 1u);
  SliceHeader header = frame.slices[0];
  header.frame = FrameId{7};
  header.server_us = 4200;
  header.gpu_us = 1500;
  Bytes body;
  append_frame_slice(body, header, frame.payload(0));
  expect_packet(body, "frame_slice_body");
  Bytes datagram;
  seal_of(Side::server)->seal(DatagramKind::frame_slice, body, datagram);
  expect_packet(datagram, "frame_slice");

  const auto client = seal_of(Side::client);
  const Bytes written = packet("frame_slice");
  const auto opened = client->open(written);
  ASSERT_TRUE(opened);
  const auto slice = decode_frame_slice(opened->body);
  ASSERT_TRUE(slice);
  EXPECT_EQ(slice->header, header);
  std::vector<uint64_t> decoded(grid.word_count());
  ASSERT_TRUE(decode_slice(slice->header, slice->payload, grid, decoded).has_value());
  EXPECT_EQ(decoded, words);
}

TEST(WireDocument, ThePictureShowsTheFrameSlicesMask) {
  const TileGrid grid{16, 8, 2};
  const std::vector<uint64_t> words = {0x00000103070f1f3f, ~uint64_t{0}, 0, 0x0000183c3c180000};
  const TileMaskView mask{grid, words};
  for (uint32_t y = 0; y < grid.height; ++y) {
    std::string row;
    for (uint32_t light = 0; light < grid.planes; ++light) {
      if (light > 0) row += y == 0 ? "    light 1: " : "             ";
      for (uint32_t x = 0; x < grid.width; ++x) row += mask.lit(x, y, light) ? '#' : '.';
    }
    EXPECT_NE(document().find(row), std::string::npos) << row;
  }
}

void expect_payload(const std::string& name, CodecId codec, TileGrid grid) {
  const tests::Mask mask = tests::all_dark(grid);
  FrameEncoder encoder;
  EncodedMask frame;
  ASSERT_TRUE(encoder.encode(mask.view(), codec, kMaxSlicePayloadBytes, frame).has_value());
  const Bytes written = packet(name);
  EXPECT_EQ(frame.bytes, written);
  std::vector<uint64_t> decoded(grid.word_count(), 1);
  ASSERT_TRUE(decode_slice(frame.slices.at(0), written, grid, decoded).has_value());
  EXPECT_EQ(decoded, mask.words);
}

TEST(WireDocument, PayloadsWithLz4AreAsWorkedOut) {
  expect_payload("dark_payload", CodecId::tiles_lz4, {512, 256, 1});
  expect_payload("raw32_payload", CodecId::raw32_lz4, {8, 8, 1});
}

TEST(WireDocument, PayloadsOfTilesContextAreAsWorkedOut) {
  const TileGrid grid{16, 8, 2};
  const std::vector<uint64_t> words = {0x00000103070f1f3f, ~uint64_t{0}, 0, 0x0000183c3c180000};
  const std::vector<uint64_t> valid_bits(words.size(), ~uint64_t{0});
  const PackedMask mask({grid, words}, valid_bits);
  ReferenceShelf shelf;
  shelf.add(std::make_shared<MaskReference>(FrameId{6}, TileMaskView{grid, words}));
  for (const MaskReference* reference : {static_cast<const MaskReference*>(nullptr), shelf.find(FrameId{6})}) {
    FrameEncoder encoder;
    EncodedMask frame;
    ASSERT_TRUE(encoder.encode(mask.view(), CodecId::tiles_context, kMaxSlicePayloadBytes, frame, reference));
    EXPECT_EQ(frame.bytes, packet("context_payload")) << "the shorter one";
    const Bytes written = packet(reference ? "referenced_payload" : "context_payload");
    std::vector<uint64_t> decoded(grid.word_count());
    ASSERT_TRUE(decode_slice(frame.slices.at(0), written, grid, decoded, &shelf));
    EXPECT_EQ(decoded, words);
  }
}

TEST(WireDocument, NamesEveryRefusalCode) {
  const auto rows = numbered_rows("## Refusal codes");
  ASSERT_EQ(rows.size(), 14u);
  for (const auto& [code, name] : rows) EXPECT_EQ(name, to_string(static_cast<RefusalCode>(code)));
}

TEST(WireDocument, TellsTheSizesOfStructures) {
  LightInfo light;
  const size_t with_one = encode(LightsChanged{{light}}).size();
  const size_t light_bytes = encode(LightsChanged{{light, light}}).size() - with_one;
  EXPECT_NE(document().find(std::to_string(light_bytes) + " bytes, after KHR_lights"), std::string::npos);

  SceneChanged changed;
  changed.scene.lights = {light};
  changed.samples = 4;
  changed.areas.resize(1);
  const size_t one_area = encode(changed).size();
  changed.scene.lights.push_back(light);
  changed.areas.push_back({});
  const size_t area_bytes = encode(changed).size() - one_area - light_bytes;
  EXPECT_NE(document().find(std::to_string(area_bytes) + " bytes: the extent of a light"), std::string::npos);

  CameraUpdate update;
  Bytes body;
  append_camera_update(body, update);
  const std::string acks = "| " + std::to_string(body.size()) + " | ";
  const size_t without = body.size();
  update.ack_count = 1;
  body.clear();
  append_camera_update(body, update);
  EXPECT_NE(document().find(acks + std::to_string(body.size() - without) + " bytes each | acks"),
            std::string::npos);
}

TEST(WireDocument, NumbersEveryMessageType) {
  const auto rows = numbered_rows("### Message types");
  ASSERT_EQ(rows.size(), std::variant_size_v<Message>);
  for (const auto& [type, name] : rows) {
    MessageReader reader;
    reader.feed(Bytes{2, 0, 0, 0, static_cast<uint8_t>(type), 0});  // without its body
    const auto read = reader.next();
    ASSERT_FALSE(read.has_value());
    EXPECT_NE(read.error().message.find(name + ":"), std::string::npos) << read.error().message;
  }
}

TEST(WireDocument, FeedbackIsAsWorkedOut) {
  Feedback feedback;
  feedback.time_us = 1050000;
  feedback.first = 5;
  feedback.recovered = 3;
  feedback.incomplete = 1;
  feedback.count = 3;
  feedback.ages = {1 + 640 / kAgeUnitUs, 0, 1};
  Bytes bytes;
  append_feedback(bytes, feedback);
  EXPECT_EQ(bytes, packet("feedback_body"));
}

TEST(WireDocument, PathValidationIsAsWorkedOut) {
  Bytes body, datagram;
  append_path_token(body, 0xc7c6c5c4c3c2c1c0);
  expect_packet(body, "path_token");
  seal_of(Side::server)->seal(DatagramKind::path_challenge, body, datagram);
  expect_packet(datagram, "path_challenge");
  const auto client = seal_of(Side::client);
  const auto challenge = client->open(packet("path_challenge"));
  ASSERT_TRUE(challenge);
  client->seal(DatagramKind::ping, Bytes(kPingBytes), datagram);
  client->seal(DatagramKind::path_response, challenge->body, datagram);
  expect_packet(datagram, "path_response");
  const auto server = seal_of(Side::server);
  const auto response = server->open(packet("path_response"));
  ASSERT_TRUE(response);
  EXPECT_EQ(decode_path_token(response->body), 0xc7c6c5c4c3c2c1c0);
  EXPECT_FALSE(decode_path_token(response->body.first(kPathTokenBytes - 1)));
}

TEST(WireDocument, ParityIsAsWorkedOut) {
  const Bytes first{1, 2, 3}, second{4};
  const auto shards = make_parity({first, second}, 1);
  Bytes bytes;
  append_parity(bytes, {FrameId{7}, 2, 1, 0, 0, 0}, shards[0]);
  EXPECT_EQ(bytes, packet("parity_body"));
  const ParityShard shard{0, std::span(bytes).subspan(kParityHeaderBytes)};
  EXPECT_EQ(rebuild({first, {}}, std::span(&shard, 1)), std::vector<Bytes>{second});
}

}  // namespace
}  // namespace gnomon::protocol
