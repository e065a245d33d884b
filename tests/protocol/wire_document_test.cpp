// WIRE.md against the code: its worked packets byte by byte, its tables of types and codes.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "protocol/codec.h"
#include "protocol/messages.h"
#include "protocol/seal.h"
#include "tests/protocol/masks.h"

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
constexpr Bytes16 kKey = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

TEST(WireDocument, HelloIsAsWorkedOut) {
  Hello hello;
  hello.client = "probe 1";
  hello.scene = "temple";
  hello.width = 1984;
  hello.height = 1116;
  hello.border_x = 64;
  hello.border_y = 36;
  hello.rate_hz = 60;
  hello.codecs = {CodecId::tiles_lz4};
  EXPECT_EQ(encode(hello), packet("hello"));
  MessageReader reader;
  reader.feed(packet("hello"));
  const auto read = reader.next();
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(**read, Message{hello});
}

TEST(WireDocument, CameraUpdateIsAsWorkedOut) {
  CameraUpdate update;
  update.frame = FrameId{7};
  update.camera = {{1, 1.5f, -2}, {0, 0.6f, 0, 0.8f}, 0.75f, 0.75f, 0.5f, 0.5f, 0.0625f};
  update.client_time_us = 1'000'000;
  update.display_deadline_us = 50'000;
  update.ack_count = 1;
  update.acks[0] = {FrameId{6}, 0, 0b111};
  Bytes body;
  append_camera_update(body, update);
  Bytes datagram;
  make_clear_seal(kSession, kKey, Side::client)->seal(DatagramKind::camera_update, body, datagram);
  EXPECT_EQ(datagram, packet("camera_update"));

  const auto server = make_clear_seal(kSession, kKey, Side::server);
  const Bytes written = packet("camera_update");
  const auto opened = server->open(written);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->header, (Header{DatagramKind::camera_update, 0, kSession, 1}));
  EXPECT_EQ(decode_camera_update(opened->body), update);
}

TEST(WireDocument, FrameSliceIsAsWorkedOut) {
  const TileGrid grid{16, 8, 2};
  const std::vector<uint64_t> words = {0x00000103070f1f3f, ~uint64_t{0}, 0, 0x0000183c3c180000};
  FrameEncoder encoder;
  EncodedFrame frame;
  ASSERT_TRUE(encoder.encode({grid, words}, CodecId::tiles_lz4, kMaxSlicePayloadBytes, frame).has_value());
  ASSERT_EQ(frame.slices.size(), 1u);
  SliceHeader header = frame.slices[0];
  header.frame = FrameId{7};
  header.server_us = 4200;
  header.gpu_us = 1500;
  Bytes body;
  append_frame_slice(body, header, frame.payload(0));
  Bytes datagram;
  make_clear_seal(kSession, kKey, Side::server)->seal(DatagramKind::frame_slice, body, datagram);
  EXPECT_EQ(datagram, packet("frame_slice"));

  const auto client = make_clear_seal(kSession, kKey, Side::client);
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
    for (uint32_t light = 0; light < grid.lights; ++light) {
      if (light > 0) row += y == 0 ? "    light 1: " : "             ";
      for (uint32_t x = 0; x < grid.width; ++x) row += mask.lit(x, y, light) ? '#' : '.';
    }
    EXPECT_NE(document().find(row), std::string::npos) << row;
  }
}

void expect_payload(const std::string& name, CodecId codec, TileGrid grid) {
  const tests::Mask mask = tests::all_dark(grid);
  FrameEncoder encoder;
  EncodedFrame frame;
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

TEST(WireDocument, NamesEveryRefusalCode) {
  const auto rows = numbered_rows("## Refusal codes");
  ASSERT_EQ(rows.size(), 12u);
  for (const auto& [code, name] : rows) EXPECT_EQ(name, to_string(static_cast<RefusalCode>(code)));
}

TEST(WireDocument, TellsTheSizesOfStructures) {
  LightInfo light;
  const size_t with_one = encode(LightsChanged{{light}}).size();
  const size_t light_bytes = encode(LightsChanged{{light, light}}).size() - with_one;
  EXPECT_NE(document().find(std::to_string(light_bytes) + " bytes, after KHR_lights"), std::string::npos);

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

}  // namespace
}  // namespace gnomon::protocol
