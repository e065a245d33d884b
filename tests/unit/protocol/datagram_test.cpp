#include "protocol/datagram.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/unit/protocol/random_messages.h"

namespace gnomon::protocol {
namespace {

using tests::Random;
using Bytes = std::vector<uint8_t>;

Bytes bytes_of(const CameraUpdate& update) {
  Bytes bytes;
  append_camera_update(bytes, update);
  return bytes;
}

Bytes bytes_of(const SliceHeader& header, std::span<const uint8_t> payload) {
  Bytes bytes;
  append_frame_slice(bytes, header, payload);
  return bytes;
}

size_t header_bytes_of(const SliceHeader& header) {
  return kSliceHeaderBytes + (header.flags & kSliceHasMoment ? kMomentBytes : 0) +
         (header.flags & kSliceHasSize ? kSizeBytes : 0) + (header.flags & kSliceHasSamples ? kSamplesBytes : 0);
}

SliceHeader random_slice(Random& random) {
  SliceHeader header;
  header.frame = FrameId{static_cast<uint32_t>(random())};
  header.slice_count = static_cast<uint16_t>(1 + random() % 65535);
  header.slice = static_cast<uint16_t>(random() % header.slice_count);
  header.first_tile = static_cast<uint32_t>(random());
  header.tile_count = static_cast<uint32_t>(1 + random() % 0xffffffff);
  header.first_light = static_cast<uint16_t>(random());
  header.light_count = static_cast<uint16_t>(1 + random() % 65535);
  header.codec = tests::one_of(random, kCodecs);
  header.server_us = static_cast<uint32_t>(random());
  header.gpu_us = static_cast<uint32_t>(random());
  header.flags = static_cast<uint8_t>(random());
  if (header.flags & kSliceHasMoment)
    header.moment = {static_cast<uint32_t>(random()), static_cast<uint32_t>(random())};
  if (header.flags & kSliceHasSize) {
    header.width = static_cast<uint16_t>(random());
    header.height = static_cast<uint16_t>(random());
  }
  if (header.flags & kSliceHasSamples) header.samples = static_cast<uint8_t>(1u << 2 * (random() % 3));
  return header;
}

TEST(Datagram, HeadersComeBackAsTheyWere) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Header header{tests::one_of(random, kDatagramKinds), static_cast<uint16_t>(random()), SessionId{random()},
                        random()};
    std::array<uint8_t, kHeaderBytes> bytes;
    write_header(bytes, header);
    EXPECT_EQ(decode_header(bytes), header);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(decode_header(std::span(bytes).first(size)));
    }
  }
}

TEST(Datagram, OtherVersionsAndKindsAreRefused) {
  Bytes bytes(kHeaderBytes);
  write_header(std::span(bytes).first<kHeaderBytes>(), {.session = SessionId{1}, .sequence = 1});
  for (int value = 0; value < 256; ++value) {
    Bytes other = bytes;
    other[0] = static_cast<uint8_t>(value);
    EXPECT_EQ(decode_header(other).has_value(), value == kVersion);
    other = bytes;
    other[1] = static_cast<uint8_t>(value);
    EXPECT_EQ(decode_header(other).has_value(), value >= 1 && value <= 9);
  }
}

TEST(Datagram, PaddingIsNoPayload) {
  SliceHeader header;
  header.slice_count = header.light_count = 1;
  header.tile_count = 1;
  header.flags = kSliceIsPadded;
  header.padding = 3;
  const Bytes payload{1, 2, 0, 0, 0};
  const Bytes padded = bytes_of(header, payload);  // the slice refers to it
  const auto slice = decode_frame_slice(padded);
  ASSERT_TRUE(slice);
  EXPECT_EQ(Bytes(slice->payload.begin(), slice->payload.end()), (Bytes{1, 2}));
  header.padding = 6;
  EXPECT_FALSE(decode_frame_slice(bytes_of(header, payload)));
  header.flags = 0;
  EXPECT_EQ(decode_frame_slice(bytes_of(header, payload))->payload.size(), 5u)
      << "without the flag it says nothing";
}

TEST(Datagram, CameraUpdatesComeBackAsTheyWere) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    const CameraUpdate update = tests::random_update(random);
    Bytes bytes = bytes_of(update);
    EXPECT_EQ(decode_camera_update(bytes), update);
    for (size_t size = 0; size < bytes.size(); ++size) {
      ASSERT_FALSE(decode_camera_update(std::span(bytes).first(size))) << size;
    }
    bytes.push_back(99);  // a later version's field
    EXPECT_EQ(decode_camera_update(bytes), update);
  }
}

TEST(Datagram, ALargestCameraUpdateFitsInADatagram) {
  CameraUpdate update;
  update.ack_count = kMaxAcks;
  EXPECT_LE(kHeaderBytes + bytes_of(update).size() + kTagBytes, kMaxDatagramBytes);
}

TEST(Datagram, CamerasThatMakeNoSenseAreRefused) {
  Random random(3);
  const CameraUpdate good = tests::random_update(random);
  ASSERT_TRUE(decode_camera_update(bytes_of(good)));
  const std::vector<std::function<void(CameraView&)>> changes = {
      [](CameraView& c) { c.position[0] = NAN; },
      [](CameraView& c) { c.position[2] = -INFINITY; },
      [](CameraView& c) {
        c.orientation = {0, 0, 0, 0};
      },
      [](CameraView& c) {
        c.orientation = {0, 0, 0, 1.01f};
      },
      [](CameraView& c) { c.orientation[3] = NAN; },
      [](CameraView& c) {
        c.orientation = {3e38f, 3e38f, 3e38f, 3e38f};
      },
      [](CameraView& c) { c.tan_left = -c.tan_right; },
      [](CameraView& c) { c.tan_up = -2 * c.tan_down - 5; },
      [](CameraView& c) { c.tan_left = c.tan_right = 3e38f; },
      [](CameraView& c) { c.tan_down = INFINITY; },
      [](CameraView& c) { c.near_plane = 0; },
      [](CameraView& c) { c.near_plane = -1; },
      [](CameraView& c) { c.near_plane = NAN; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    CameraUpdate bad = good;
    changes[i](bad.camera);
    EXPECT_FALSE(decode_camera_update(bytes_of(bad))) << "change " << i;
  }
  CameraUpdate nearly = good;  // a float's rounding of a unit quaternion is no fault
  for (float& component : nearly.camera.orientation) component *= 1.0005f;
  EXPECT_TRUE(decode_camera_update(bytes_of(nearly)));
}

TEST(Datagram, TooManyAcknowledgementsAreRefused) {
  Bytes bytes = bytes_of(CameraUpdate{});
  bytes.back() = kMaxAcks + 1;
  bytes.resize(bytes.size() + 100 * 14);
  EXPECT_FALSE(decode_camera_update(bytes));
}

TEST(Datagram, FrameSlicesComeBackAsTheyWere) {
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    const SliceHeader header = random_slice(random);
    Bytes payload(random() % 50);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
    const Bytes bytes = bytes_of(header, payload);
    const auto slice = decode_frame_slice(bytes);
    ASSERT_TRUE(slice);
    EXPECT_EQ(slice->header, header);
    EXPECT_TRUE(std::equal(slice->payload.begin(), slice->payload.end(), payload.begin(), payload.end()));
    const size_t header_bytes = header_bytes_of(header);
    EXPECT_EQ(bytes.size(), header_bytes + payload.size());
    for (size_t size = 0; size < header_bytes; ++size) {
      EXPECT_FALSE(decode_frame_slice(std::span(bytes).first(size)));
    }
  }
}

TEST(Datagram, SlicesThatMakeNoSenseAreRefused) {
  Random random(5);
  const std::vector<std::function<void(SliceHeader&)>> changes = {
      [](SliceHeader& h) { h.slice = h.slice_count; },
      [](SliceHeader& h) { h.slice = h.slice_count = 0; },
      [](SliceHeader& h) { h.tile_count = 0; },
      [](SliceHeader& h) { h.light_count = 0; },
      [](SliceHeader& h) {
        h.flags |= kSliceHasSamples;
        h.samples = 8;
      },
  };
  for (const auto& change : changes) {
    SliceHeader header = random_slice(random);
    change(header);
    EXPECT_FALSE(decode_frame_slice(bytes_of(header, {})));
  }
}

TEST(Datagram, RandomBytesGiveAValueOrNothing) {
  Random random(6);
  for (int i = 0; i < 50000; ++i) {
    Bytes bytes(random() % 120);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random() % 2 ? random() : random() % 3);
    decode_header(bytes);
    if (const auto slice = decode_frame_slice(bytes)) {
      const size_t padding = slice->header.flags & kSliceIsPadded ? slice->header.padding : 0;
      EXPECT_EQ(slice->payload.size(), bytes.size() - header_bytes_of(slice->header) - padding);
    }
    if (const auto update = decode_camera_update(bytes)) {
      EXPECT_LE(update->ack_count, kMaxAcks);
      EXPECT_TRUE(is_valid(update->camera));
    }
  }
}

}  // namespace
}  // namespace gnomon::protocol
