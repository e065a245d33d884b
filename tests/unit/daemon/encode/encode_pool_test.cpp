#include "daemon/encode/encode_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>

#include "tests/unit/protocol/masks.h"

namespace gnomon::daemon {
namespace {

constexpr TileGrid kGrid{1280, 720, 4};

class KeptFrames final : public FrameSink {
 public:
  void on_rendered(RenderedFrame) override {}
  void on_encoded(EncodedFrame frame) override {
    std::lock_guard lock(mutex_);
    const uint32_t frame_number = frame.meta.route.frame.value;
    frames_.emplace(frame_number, std::move(frame));
    arrived_.notify_one();
  }
  void on_degraded(const SessionDegraded&) override {}
  void on_lights(const LightsUpdate&) override {}

  std::map<uint32_t, EncodedFrame> wait_for(size_t count) {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [&] { return frames_.size() >= count; });
    return std::move(frames_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<uint32_t, EncodedFrame> frames_;
};

class EncodePoolTest : public testing::Test {
 protected:
  RenderedFrame rendered(FrameId frame, const PackedMask& mask, protocol::CodecId codec) {
    RenderedFrame made;
    made.meta.route.frame = frame;
    made.meta.spec.codec = codec;
    made.meta.spec.grid = mask.view().grid;
    ++leases_;
    made.mask = gpu::FrameLease(mask.view(), [this] { --leases_; });
    return made;
  }

  static PackedMask packed(const tests::Mask& mask) {
    return PackedMask(mask.view(), std::vector<uint64_t>(mask.words.size(), ~uint64_t{0}));
  }

  Metrics metrics_{{"default"}, {}, "test"};
  KeptFrames sink_;
  std::atomic<int> leases_ = 0;
};

// Whatever the codec and the number of workers, a frame's slices are those that one encoder makes.
TEST_F(EncodePoolTest, WorkersShareAFrameAndItsSlicesDoNotDependOnTheirNumber) {
  const std::vector<PackedMask> masks = {packed(tests::foliage(kGrid, 1)), packed(tests::room(kGrid, 2)),
                                         packed(tests::all_lit({640, 360, 1})),
                                         packed(tests::all_dark({640, 360, 0}))};
  ASSERT_GT(protocol::SplitFrame::of_bands(masks[0].view(), protocol::kMaxSlicePayloadBytes).unit_count(), 2u);
  constexpr size_t kFrames = 24;
  for (const uint32_t workers : {1u, 2u, 5u}) {
    const auto mask_of = [&](size_t i) -> const PackedMask& { return masks[i % masks.size()]; };
    const auto codec_of = [](size_t i) { return protocol::kCodecs[i / 4 % std::size(protocol::kCodecs)]; };
    {
      EncodePool pool(workers, {}, metrics_, sink_);
      for (size_t i = 0; i < kFrames; ++i)
        pool.push(rendered(FrameId{static_cast<uint32_t>(i)}, mask_of(i), codec_of(i)));
      for (const auto& [i, frame] : sink_.wait_for(kFrames)) {
        protocol::EncodedMask expected;
        const size_t room = frame.meta.spec.slice_body_bytes - protocol::kSliceHeaderBytes;
        ASSERT_TRUE(protocol::FrameEncoder().encode(mask_of(i).view(), codec_of(i), room, expected));
        EXPECT_EQ(frame.slices.slices, expected.slices);
        EXPECT_EQ(frame.slices.bytes, expected.bytes);
        EXPECT_EQ(frame.slices.offsets, expected.offsets);
      }
    }
    EXPECT_EQ(leases_, 0);
  }
}

// What waits when the daemon stops gives its frame slot back.
TEST_F(EncodePoolTest, LeasesOfWhatIsDroppedAtTheEndComeBack) {
  const PackedMask mask = packed(tests::foliage(kGrid, 1));
  {
    EncodePool pool(2, {}, metrics_, sink_);
    for (uint32_t i = 0; i < 40; ++i) pool.push(rendered(FrameId{i}, mask, protocol::CodecId::tiles_lz4));
  }
  EXPECT_EQ(leases_, 0);
}

}  // namespace
}  // namespace gnomon::daemon
