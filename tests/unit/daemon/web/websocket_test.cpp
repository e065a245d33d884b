#include "daemon/web/websocket.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "daemon/web/message_stream.h"
#include "tests/unit/daemon/web/client_frames.h"

namespace gnomon::daemon::web {
namespace {

using Kind = FrameReader::Event::Kind;
using Bytes = std::vector<uint8_t>;

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

std::optional<FrameReader::Event> event_of(FrameReader& reader) {
  auto read = reader.next();
  const auto* event = std::get_if<std::optional<FrameReader::Event>>(&read);
  EXPECT_NE(event, nullptr) << std::get<Violation>(read).why;
  return event ? *event : std::nullopt;
}

std::optional<CloseCode> violation_of(const Bytes& bytes, size_t max = 1000) {
  FrameReader reader(max);
  reader.feed(bytes);
  while (true) {
    auto read = reader.next();
    if (const auto* violation = std::get_if<Violation>(&read)) return violation->code;
    if (!std::get<std::optional<FrameReader::Event>>(read)) return std::nullopt;
  }
}

TEST(WebSocket, ReadsTheExamplesOfItsSpecification) {  // RFC 6455, 5.7
  FrameReader reader(1000);
  reader.feed(Bytes{0x89, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58});
  const auto ping = event_of(reader);
  ASSERT_TRUE(ping);
  EXPECT_EQ(ping->kind, Kind::ping);
  EXPECT_EQ(ping->payload, bytes_of("Hello"));
  // Its text frame "Hello", as a binary one.
  reader.feed(Bytes{0x82, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58});
  const auto message = event_of(reader);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->kind, Kind::message);
  EXPECT_EQ(message->payload, bytes_of("Hello"));
}

TEST(WebSocket, WritesTheExamplesOfItsSpecification) {
  Bytes pong;
  append_frame(pong, Opcode::pong, bytes_of("Hello"));
  EXPECT_EQ(pong, (Bytes{0x8a, 0x05, 0x48, 0x65, 0x6c, 0x6c, 0x6f}));
  Bytes middle, large;
  append_frame(middle, Opcode::binary, Bytes(256));
  EXPECT_EQ(Bytes(middle.begin(), middle.begin() + 4), (Bytes{0x82, 0x7e, 0x01, 0x00}));
  append_frame(large, Opcode::binary, Bytes(65536));
  EXPECT_EQ(Bytes(large.begin(), large.begin() + 10), (Bytes{0x82, 0x7f, 0, 0, 0, 0, 0, 1, 0, 0}));
}

TEST(WebSocket, MessagesOfAnyLengthArriveInPiecesOfAnyLength) {
  std::mt19937 random(1);
  for (const size_t size : {0, 1, 125, 126, 127, 1000, 65535, 65536, 70000}) {
    Bytes payload(size);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
    const Bytes frame = client_frame(Opcode::binary, payload);
    FrameReader reader(100'000);
    std::optional<FrameReader::Event> event;
    for (size_t at = 0; at < frame.size();) {
      EXPECT_FALSE(event);
      const size_t piece = std::min<size_t>(1 + random() % 5000, frame.size() - at);
      reader.feed(std::span(frame).subspan(at, piece));
      at += piece;
      event = event_of(reader);
    }
    ASSERT_TRUE(event) << size;
    EXPECT_EQ(event->payload, payload);
  }
}

TEST(WebSocket, FragmentsAreJoinedAndControlFramesMayStandBetweenThem) {
  FrameReader reader(10);
  reader.feed(client_frame(Opcode::binary, bytes_of("Hel"), {.final = false}));
  reader.feed(client_frame(Opcode::ping, bytes_of("?")));
  reader.feed(client_frame(Opcode::continuation, bytes_of("lo")));
  EXPECT_EQ(event_of(reader)->kind, Kind::ping);
  EXPECT_EQ(event_of(reader)->payload, bytes_of("Hello"));
  EXPECT_FALSE(event_of(reader));
}

TEST(WebSocket, RefusesWhatNoClientMaySend) {
  const Bytes hello = bytes_of("Hello");
  const auto fragment = client_frame(Opcode::binary, hello, {.final = false});
  const auto then = [](Bytes first, const Bytes& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  };
  EXPECT_EQ(violation_of(client_frame(Opcode::binary, hello, {.masked = false})), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(Opcode::binary, hello, {.reserved = 0x40})), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(Opcode::text, hello)), CloseCode::unsupported_data);
  EXPECT_EQ(violation_of(client_frame(Opcode::continuation, hello)), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(static_cast<Opcode>(3), hello)), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(static_cast<Opcode>(11), hello)), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(Opcode::ping, Bytes(126))), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(Opcode::ping, hello, {.final = false})), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(client_frame(Opcode::close, Bytes(1))), CloseCode::protocol_error);
  EXPECT_EQ(violation_of(then(fragment, client_frame(Opcode::binary, hello))), CloseCode::protocol_error);
  // A length that takes fewer bytes (RFC 6455, 5.2), and one whose highest bit is set.
  EXPECT_EQ(violation_of({0x82, 0xfe, 0, 125}), CloseCode::protocol_error);
  EXPECT_EQ(violation_of({0x82, 0xff, 0, 0, 0, 0, 0, 0, 0xff, 0xff}), CloseCode::protocol_error);
  EXPECT_EQ(violation_of({0x82, 0xff, 0x80, 0, 0, 0, 0, 1, 0, 0}), CloseCode::protocol_error);
}

TEST(WebSocket, RefusesAMessageThatIsTooLongBeforeItIsHere) {
  EXPECT_EQ(violation_of({0x82, 0xfe, 0x03, 0xe9}), CloseCode::too_big);  // 1001 bytes
  EXPECT_EQ(violation_of({0x82, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}), CloseCode::too_big);
  Bytes fragments = client_frame(Opcode::binary, Bytes(600), {.final = false});
  const Bytes more = client_frame(Opcode::continuation, Bytes(401), {.final = false});
  fragments.insert(fragments.end(), more.begin(), more.end());
  EXPECT_EQ(violation_of(fragments), CloseCode::too_big);
}

TEST(WebSocket, RefusesAMessageInEndlesslyManyFragments) {
  Bytes endless = client_frame(Opcode::binary, {}, {.final = false});
  for (int i = 0; i < 64; ++i) {
    const Bytes empty = client_frame(Opcode::continuation, {}, {.final = false});
    endless.insert(endless.end(), empty.begin(), empty.end());
  }
  EXPECT_EQ(violation_of(endless), CloseCode::policy);
}

TEST(MessageStream, CarriesOneControlMessageInEachMessage) {
  const Bytes bye = protocol::encode(protocol::Bye{"done"});
  MessageStream stream(1000);
  stream.become_websocket();
  stream.feed(client_frame(Opcode::binary, bye));
  const auto message = stream.next();
  ASSERT_TRUE(message && *message);
  EXPECT_EQ(std::get<protocol::Bye>(**message).reason, "done");
  const Bytes framed = stream.framed(bye);
  EXPECT_EQ(Bytes(framed.end() - static_cast<ptrdiff_t>(bye.size()), framed.end()), bye);
  Bytes two = bye;
  two.insert(two.end(), bye.begin(), bye.end());
  for (const Bytes& wrong : {two, Bytes(bye.begin(), bye.end() - 1), Bytes{}}) {
    MessageStream other(1000);
    other.become_websocket();
    other.feed(client_frame(Opcode::binary, wrong));
    EXPECT_FALSE(other.next());
    EXPECT_EQ(other.farewell(), (Bytes{0x88, 2, 0x03, 0xeb}));  // 1003
  }
}

TEST(MessageStream, AnswersPingsAndTheClientsClose) {
  MessageStream stream(1000);
  stream.become_websocket();
  stream.feed(client_frame(Opcode::ping, bytes_of("?")));
  EXPECT_TRUE(stream.next());
  EXPECT_EQ(stream.take_replies(), (Bytes{0x8a, 1, '?'}));
  stream.feed(client_frame(Opcode::close, {}));
  EXPECT_TRUE(stream.next());
  EXPECT_TRUE(stream.is_closed());
  EXPECT_EQ(stream.take_replies(), (Bytes{0x88, 2, 0x03, 0xe8}));
  EXPECT_TRUE(stream.farewell().empty());
}

}  // namespace
}  // namespace gnomon::daemon::web
