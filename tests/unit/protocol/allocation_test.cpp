// Untrusted input costs no memory: datagrams are sealed, opened and decoded without allocating, and an encoder that has
// warmed up encodes without allocating.
#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "protocol/messages.h"
#include "protocol/seal.h"
#include "tests/tools/allocations/allocations.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::protocol {
namespace {

constexpr SealSecrets kSecrets{{9, 9, 9}, {8, 8}};

template <class Work>
size_t allocations_of(Work work) {
  const uint64_t before = test::allocations();
  work();
  return test::allocations() - before;
}

TEST(Allocations, AreCounted) {
  EXPECT_GE(allocations_of([] { encode(Draining{1}); }), 1u);
}

TEST(Allocations, NoneForACameraUpdate) {
  Seal client(SessionId{1}, CipherId::aes_128_gcm, kSecrets, Side::client);
  Seal server(SessionId{1}, CipherId::aes_128_gcm, kSecrets, Side::server);
  CameraUpdate update;
  update.ack_count = kMaxAcks;
  std::vector<uint8_t> body, datagram;
  body.reserve(kMaxDatagramBytes);
  datagram.reserve(kMaxDatagramBytes);
  bool same = false;
  EXPECT_EQ(allocations_of([&] {
              append_camera_update(body, update);
              client.seal(DatagramKind::camera_update, body, datagram);
              same = decode_camera_update(server.open(datagram)->body) == update;
              datagram.back() ^= 1;
              same = same && !server.open(datagram);
            }),
            0u);
  EXPECT_TRUE(same);
}

TEST(Allocations, NoneForAFrameOnceTheEncoderIsWarm) {
  const tests::Mask mask = tests::room({640, 360, 3}, 1);
  std::vector<uint64_t> words(mask.words.size());
  for (const CodecId codec : {CodecId::raw32_lz4, CodecId::tiles_lz4}) {
    FrameEncoder encoder;
    EncodedMask frame;
    bool good = true;
    const auto round_trip = [&] {
      good &= encoder.encode(mask.view(), codec, kMaxSlicePayloadBytes, frame).has_value();
      for (size_t i = 0; i < frame.slices.size(); ++i) {
        good &= decode_slice(frame.slices[i], frame.payload(i), mask.grid, words).has_value();
      }
    };
    round_trip();
    EXPECT_EQ(allocations_of(round_trip), 0u);
    EXPECT_TRUE(good && words == mask.words);
  }
}

}  // namespace
}  // namespace gnomon::protocol
