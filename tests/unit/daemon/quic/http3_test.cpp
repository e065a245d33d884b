// HTTP/3 of one connection from bytes of streams, however they are cut.
#include "daemon/quic/http3.h"

#include <gtest/gtest.h>

#include "daemon/quic/qpack.h"
#include "daemon/quic/varint.h"

namespace gnomon::daemon::quic {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes frame(uint64_t type, const Bytes& body) {
  Bytes out;
  append_varint(out, type);
  append_varint(out, body.size());
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

Bytes request(const char* protocol = "webtransport") {
  return frame(1, encode_fields({{":method", "CONNECT"},
                                 {":protocol", protocol},
                                 {":scheme", "https"},
                                 {":authority", "a"},
                                 {":path", "/p"},
                                 {"origin", "https://o"}}));
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Varint, OfEachWidthComesBack) {
  for (const uint64_t value :
       {0ull, 63ull, 64ull, 16383ull, 16384ull, (1ull << 30) - 1, 1ull << 30, (1ull << 62) - 1}) {
    Bytes bytes;
    append_varint(bytes, value);
    for (size_t cut = 0; cut < bytes.size(); ++cut) {
      std::span<const uint8_t> part = std::span(bytes).first(cut);
      EXPECT_FALSE(take_varint(part));
    }
    std::span<const uint8_t> whole = bytes;
    EXPECT_EQ(take_varint(whole), value);
    EXPECT_TRUE(whole.empty());
  }
}

TEST(Http3, RequestIsReadByteByByteBehindUnknownFrames) {
  Http3 http;
  for (const uint8_t byte : frame(0x21, Bytes(300, 7)) + request()) {
    EXPECT_FALSE(http.take_asked());
    ASSERT_FALSE(http.receive(4, Bytes{byte}, false));
  }
  const auto asked = http.take_asked();
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->origin, "https://o");
  EXPECT_EQ(http.session_stream(), 4);
  EXPECT_EQ(http.datagram_prefix(), Bytes{1});
  EXPECT_TRUE(http.payload(Bytes{1, 9}));
  EXPECT_FALSE(http.payload(Bytes{0, 9})) << "of another stream";
  EXPECT_FALSE(http.payload(Bytes{}));
  EXPECT_FALSE(http.ended());
  ASSERT_FALSE(http.receive(4, Bytes{}, true));
  EXPECT_TRUE(http.ended());
}

TEST(Http3, DraftsAreKnownByTheirProtocol) {
  for (const char* known : {"webtransport", "webtransport-h3"}) {
    Http3 http;
    EXPECT_FALSE(http.receive(0, request(known), false));
    EXPECT_TRUE(http.take_asked()) << known;
  }
  Http3 http;
  EXPECT_TRUE(http.receive(0, request("websocket"), false));
}

TEST(Http3, SecondSessionIsNone) {
  Http3 http;
  ASSERT_FALSE(http.receive(0, request(), false));
  EXPECT_TRUE(http.take_asked());
  ASSERT_FALSE(http.receive(4, request(), false));
  EXPECT_FALSE(http.take_asked());
  http.reset(4);
  EXPECT_FALSE(http.ended());
  http.reset(0);
  EXPECT_TRUE(http.ended());
}

TEST(Http3, WhatBreaksTheRulesHasItsCode) {
  const auto code = [](int64_t stream, const Bytes& bytes, bool ended = false) -> uint64_t {
    Http3 http;
    const auto error = http.receive(stream, bytes, ended);
    return error ? error->code : 0;
  };
  const Bytes settings = frame(4, {8, 1});
  EXPECT_EQ(code(2, Bytes{0} + settings), 0u);
  EXPECT_EQ(code(2, Bytes{0} + settings, true), 0x104u) << "the control stream ends";
  EXPECT_EQ(code(2, Bytes{0} + settings + settings), 0x105u);
  EXPECT_EQ(code(2, Bytes{0} + frame(7, {0})), 0x10au) << "something before the settings";
  EXPECT_EQ(code(2, Bytes{0} + frame(4, {8})), 0x109u) << "half a setting";
  EXPECT_EQ(code(2, Bytes{1}), 0x103u) << "a push";
  EXPECT_EQ(code(2, Bytes{0} + settings + frame(1, {})), 0x105u);
  EXPECT_EQ(code(0, settings), 0x105u);
  EXPECT_EQ(code(0, frame(1, {0xff, 0xff, 0xff})), 0x200u) << "no field section";
  Bytes endless{1};
  append_varint(endless, Http3::kLongestFrame + 1);
  EXPECT_EQ(code(0, endless), 0x107u);
  Http3 http;
  for (int64_t stream = 2; stream < 2 + 4 * static_cast<int64_t>(Http3::kMostStreams); stream += 4) {
    ASSERT_FALSE(http.receive(stream, Bytes{0x21}, false));
  }
  EXPECT_TRUE(http.receive(1002, Bytes{0x21}, false));
}

TEST(Http3, FieldsBeyondTheBoundAreRefused) {
  EXPECT_TRUE(decode_fields(encode_fields({{"a", "b"}})));
  EXPECT_FALSE(decode_fields(encode_fields({{"a", std::string(kLongestField, 'x')}})));
  std::vector<std::pair<std::string, std::string>> many;
  for (size_t i = 0; i <= kMostFields; ++i) many.emplace_back("n" + std::to_string(i), "v");
  EXPECT_FALSE(decode_fields(encode_fields(many)));
}

}  // namespace
}  // namespace gnomon::daemon::quic
