// The Renderer contract: slots, leases, errors.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr SceneId kScene{1};

// Collects what the completion thread delivers.
class Frames {
 public:
  std::function<void(FrameDone)> take() {
    return [this](FrameDone done) {
      std::lock_guard lock(mutex_);
      done_.push_back(std::move(done));
      arrived_.notify_all();
    };
  }
  std::vector<FrameDone>& wait_for(size_t count) {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [&] { return done_.size() >= count; });
    return done_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<FrameDone> done_;
};

RenderJob job(uint64_t id, uint32_t width, uint32_t height, float eye_x = 3.0f) {
  return {JobId(id), kScene, look_at({eye_x, 4.0f, 5.0f}, {0, 0, 0}, 0.9f, width, height), width, height};
}

std::unique_ptr<Renderer> renderer_with_scene(uint32_t frames_in_flight = 3) {
  RendererOptions options = full_size_options();
  options.frames_in_flight = frames_in_flight;
  auto renderer = make_renderer(options);
  EXPECT_TRUE(renderer) << renderer.error().message;
  const auto resident = (*renderer)->make_resident(kScene, square_over_floor(point_light({0.7f, 3.0f, -0.4f})));
  EXPECT_TRUE(resident) << resident.error().message;
  return std::move(*renderer);
}

size_t lit_bits(const PackedMaskView& mask) {
  size_t bits = 0;
  for (const uint64_t word : unpacked(mask)) bits += static_cast<size_t>(__builtin_popcountll(word));
  return bits;
}

TEST(RendererTest, SlotsComeBackWhenLeasesAreDropped) {
  auto renderer = renderer_with_scene(3);
  Frames frames;
  EXPECT_EQ(renderer->free_slots(), 3u);
  for (uint64_t i = 0; i < 3; ++i) ASSERT_TRUE(renderer->submit(job(i, 128, 72), frames.take()));
  auto& done = frames.wait_for(3);
  EXPECT_EQ(renderer->free_slots(), 0u);
  EXPECT_FALSE(renderer->submit(job(9, 128, 72), frames.take())) << "no slot is free";
  for (uint64_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(done[i].device_lost);
    EXPECT_GT(done[i].gpu_ns, 0u);
    EXPECT_EQ(done[i].stages.front().pass, renderer->info().raster == "compute" ? "clear" : "cull");
    EXPECT_EQ(done[i].stages.back().pass, "readback");
    EXPECT_GT(lit_bits(done[i].mask.mask()), 1000u);
  }
  done[1].mask.drop();
  EXPECT_EQ(renderer->free_slots(), 1u);
  done.clear();
  EXPECT_EQ(renderer->free_slots(), 3u);
}

std::vector<uint64_t> words_of(const FrameDone& done) { return unpacked(done.mask.mask()); }

// A frame in bands, with other frames in between, equals the frame in one submit, bit for bit.
TEST(RendererTest, BandsMakeTheSameFrame) {
  auto renderer = renderer_with_scene(3);
  const TileGrid grid{200, 120, 1};
  for (const uint32_t rows : {0u, 1u, 4u, 7u, grid.tiles_y() - 1}) {
    Frames whole, banded, other;
    ASSERT_TRUE(renderer->submit(job(1, grid.width, grid.height), whole.take()));
    RenderJob begun = job(2, grid.width, grid.height);
    begun.tile_rows = rows;
    ASSERT_TRUE(renderer->submit(begun, banded.take()));
    size_t bands = 1;
    const uint32_t further = std::max(rows, 1u);
    for (uint32_t done = rows; done < grid.tiles_y(); done += further, ++bands) {
      ASSERT_TRUE(renderer->submit(job(10 + bands, 64, 64, 1.0f), other.take()));
      other.wait_for(bands).back().mask.drop();
      ASSERT_TRUE(renderer->resume(JobId(2), further, banded.take()));
    }
    const auto& done = banded.wait_for(bands);
    for (size_t band = 0; band < bands; ++band) {
      EXPECT_EQ(done[band].complete, band + 1 == bands);
      EXPECT_GT(done[band].gpu_ns, 0u);
    }
    EXPECT_EQ(words_of(done.back()), words_of(whole.wait_for(1)[0])) << rows << " rows";
    EXPECT_FALSE(renderer->resume(JobId(2), 1, banded.take())) << "it is complete";
  }
  EXPECT_EQ(renderer->free_slots(), 3u);
}

// Untraced lights are lit everywhere, and the other lights are unchanged.
TEST(RendererTest, UntracedLightsAreLit) {
  auto renderer = renderer_with_scene(2);
  constexpr SceneId kSoup{2};
  constexpr uint32_t kLights = 5;
  ASSERT_TRUE(renderer->make_resident(kSoup, triangle_soup(11, 200, kLights)));
  const TileGrid grid{150, 90, kLights};
  RenderJob all = job(1, grid.width, grid.height), some = job(2, grid.width, grid.height);
  all.scene = some.scene = kSoup;
  some.untraced = LightSet(0b01010);
  some.tile_rows = 5;
  Frames frames, whole;
  ASSERT_TRUE(renderer->submit(all, whole.take()));
  ASSERT_TRUE(renderer->submit(some, frames.take()));
  ASSERT_TRUE(renderer->resume(JobId(2), 100, frames.take()));
  const auto expected = words_of(whole.wait_for(1)[0]);
  const auto words = words_of(frames.wait_for(2)[1]);
  for (size_t i = 0; i < grid.word_count(); ++i) {
    const bool traced = !some.untraced[i / grid.tile_count()];
    ASSERT_EQ(words[i], traced ? expected[i] : ~uint64_t{0}) << i;
  }
}

TEST(RendererTest, AnAbandonedFrameGivesItsSlotBack) {
  auto renderer = renderer_with_scene(1);
  std::atomic<int> freed = 0;
  renderer->on_slot_freed([&] { ++freed; });
  Frames frames;
  RenderJob begun = job(1, 128, 72);
  begun.tile_rows = 2;
  ASSERT_TRUE(renderer->submit(begun, frames.take()));
  EXPECT_EQ(renderer->free_slots(), 0u);
  renderer->abandon(JobId(1));
  frames.wait_for(1);
  EXPECT_FALSE(renderer->resume(JobId(1), 2, frames.take()));
  while (freed == 0) std::this_thread::yield();  // who waits for a slot is told
  EXPECT_EQ(renderer->free_slots(), 1u);
  ASSERT_TRUE(renderer->submit(job(2, 128, 72), frames.take()));
  EXPECT_TRUE(frames.wait_for(2).back().complete);
}

TEST(RendererTest, ABatchStartsAtItsEnd) {
  auto renderer = renderer_with_scene(3);
  Frames frames;
  renderer->begin_batch();
  for (uint64_t i = 0; i < 3; ++i) ASSERT_TRUE(renderer->submit(job(i, 64, 64), frames.take()));
  renderer->end_batch();
  std::set<JobId> done;  // frames of several queues end in any order
  for (const FrameDone& frame : frames.wait_for(3)) done.insert(frame.id);
  EXPECT_EQ(done, (std::set{JobId(0), JobId(1), JobId(2)}));
}

TEST(RendererTest, ALeaseKeepsItsMaskWhileOtherFramesRun) {
  auto renderer = renderer_with_scene(2);
  Frames held, others;
  ASSERT_TRUE(renderer->submit(job(0, 160, 90), held.take()));
  const PackedMaskView mask = held.wait_for(1)[0].mask.mask();
  const std::vector<uint64_t> before = unpacked(mask);
  for (uint64_t i = 1; i <= 6; ++i) {
    ASSERT_TRUE(renderer->submit(job(i, 200, 120, static_cast<float>(i)), others.take()));
    others.wait_for(i).back().mask.drop();
  }
  EXPECT_EQ(unpacked(mask), before);
}

TEST(RendererTest, LeasesOutliveTheRenderer) {
  auto renderer = renderer_with_scene();
  Frames frames;
  ASSERT_TRUE(renderer->submit(job(0, 128, 72), frames.take()));
  auto& done = frames.wait_for(1);
  const size_t before = lit_bits(done[0].mask.mask());
  renderer.reset();
  EXPECT_EQ(lit_bits(done[0].mask.mask()), before);
  done.clear();
}

TEST(RendererTest, DestructionDeliversWhatIsInFlight) {
  Frames frames;
  {
    auto renderer = renderer_with_scene();
    for (uint64_t i = 0; i < 3; ++i) ASSERT_TRUE(renderer->submit(job(i, 320, 200), frames.take()));
  }
  EXPECT_EQ(frames.wait_for(3).size(), 3u);
}

// Sizes go up and down through the same slot; each frame equals that of a fresh renderer.
TEST(RendererTest, EverySizeGetsItsOwnMask) {
  auto renderer = renderer_with_scene(1);
  const std::vector<std::pair<uint32_t, uint32_t>> sizes{{64, 64}, {200, 30}, {17, 90}, {64, 64}, {1, 1}};
  for (const auto& [width, height] : sizes) {
    Frames frames, fresh_frames;
    ASSERT_TRUE(renderer->submit(job(0, width, height), frames.take()));
    auto fresh = renderer_with_scene(1);
    ASSERT_TRUE(fresh->submit(job(0, width, height), fresh_frames.take()));
    const auto a = frames.wait_for(1)[0].mask.mask(), b = fresh_frames.wait_for(1)[0].mask.mask();
    EXPECT_EQ(a.grid, (TileGrid{width, height, 1}));
    EXPECT_EQ(unpacked(a), unpacked(b)) << width << "x" << height;
  }
}

TEST(RendererTest, ASceneMayBeEvictedWhileItsFramesAreInFlight) {
  auto renderer = renderer_with_scene();
  Frames frames;
  ASSERT_TRUE(renderer->submit(job(0, 320, 200), frames.take()));
  renderer->evict(kScene);
  EXPECT_GT(lit_bits(frames.wait_for(1)[0].mask.mask()), 1000u);
  EXPECT_FALSE(renderer->submit(job(1, 320, 200), frames.take())) << "the scene is gone";
  ASSERT_TRUE(renderer->make_resident(kScene, square_over_floor(sun({0, -1, 0}))));
  ASSERT_TRUE(renderer->submit(job(2, 320, 200), frames.take()));
  EXPECT_GT(lit_bits(frames.wait_for(2)[1].mask.mask()), 1000u);
}

TEST(RendererTest, RefusesWhatItCannotRender) {
  auto renderer = renderer_with_scene();
  Frames frames;
  for (const auto& [width, height] : std::vector<std::pair<uint32_t, uint32_t>>{{0, 8}, {8, 0}, {1u << 20, 8}}) {
    const auto refused = renderer->submit(job(0, width, height), frames.take());
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("the device renders from 1x1"), std::string::npos);
  }
  RenderJob unknown = job(0, 64, 64);
  unknown.scene = SceneId(77);
  EXPECT_FALSE(renderer->submit(unknown, frames.take()));
  EXPECT_EQ(renderer->free_slots(), 3u);
}

TEST(RendererTest, ASceneWithTooManyLightsIsRefused) {
  auto renderer = renderer_with_scene();
  const auto refused = renderer->make_resident(SceneId(2), triangle_soup(1, 10, kMaxLights + 1));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("lights"), std::string::npos);
}

TEST(RendererTest, ScenesWithoutLightsOrTrianglesAreRendered) {
  auto renderer = renderer_with_scene();
  for (const std::string& tracer : tracers()) {
    auto other = make_renderer(device_options(tracer));
    ASSERT_TRUE(other) << other.error().message;
    ASSERT_TRUE((*other)->make_resident(SceneId(1), triangle_soup(1, 10, 0)));
    ASSERT_TRUE((*other)->make_resident(SceneId(2), triangle_soup(1, 0, 2)));
    for (uint32_t scene = 1; scene <= 2; ++scene) {
      Frames frames;
      RenderJob empty = job(0, 64, 64);
      empty.scene = SceneId(scene);
      ASSERT_TRUE((*other)->submit(empty, frames.take()));
      EXPECT_EQ(lit_bits(frames.wait_for(1)[0].mask.mask()), 0u);
    }
  }
}

TEST(RendererTest, OptionsThatDoNotFitAreErrors) {
  RendererOptions options = device_options();
  options.device = "no such device";
  auto refused = make_renderer(options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("no such device"), std::string::npos);

  refused = make_renderer(device_options("no such tracer"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("bvh"), std::string::npos) << "names the tracers there are";

  options = device_options();
  options.passes = {"gbuffer", "sharpen", "pack", "readback"};
  refused = make_renderer(options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("sharpen"), std::string::npos);

  options.passes = {"trace", "gbuffer", "pack", "readback"};
  refused = make_renderer(options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("triangle_id"), std::string::npos) << "names what is missing";

  options.passes = {"gbuffer", "trace"};
  EXPECT_FALSE(make_renderer(options)) << "nothing reaches the host";
}

TEST(DeviceChoice, ByIndexTypeAndName) {
  const auto any = Device::create({});
  ASSERT_TRUE(any) << any.error().message;
  const std::string name = (*any)->info().name;
  const auto by_name = Device::create({name.substr(0, 4), {}});
  ASSERT_TRUE(by_name) << by_name.error().message;
  EXPECT_TRUE(Device::create({"0", {}}));
  EXPECT_FALSE(Device::create({"99", {}}));
  if ((*any)->info().type == VK_PHYSICAL_DEVICE_TYPE_CPU) {
    EXPECT_TRUE(Device::create({"cpu", {}}));
    EXPECT_FALSE(Device::create({"integrated", {}}));
  }
}

}  // namespace
}  // namespace gnomon::test
