// Soft frames of a renderer: in bands, with lights that are not traced, and packed.
#include <gtest/gtest.h>

#include <future>

#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 100, kHeight = 60;
constexpr SceneId kScene{0};

class SoftFrames : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = with_areas(*triangle_soup(6, 250, 6), 0.2f);
    auto renderer = make_renderer(device_options());
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
    ASSERT_TRUE(renderer_->make_resident(kScene, scene_));
  }

  RenderJob job(SampleCounts samples) const {
    RenderJob job{JobId(next_), kScene, look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight),
                  kWidth, kHeight};
    job.samples = samples;
    return job;
  }

  struct Frame {
    TileGrid grid;
    std::vector<uint64_t> words;
    std::vector<PackedClass> classes;
    uint64_t trace_ns = 0;
  };
  // `rows`: of each band; 0: all in one.
  Frame render(RenderJob job, uint32_t rows = 0) {
    std::promise<Frame> arrived;
    const auto deliver = [&](FrameDone done) {
      if (!done.complete) return;
      const PackedMaskView mask = done.mask.mask();
      Frame frame{mask.grid, unpacked(mask), {}, done.trace_ns};
      for (size_t i = 0; i < mask.grid.word_count(); ++i) frame.classes.push_back(mask.class_of(i));
      arrived.set_value(std::move(frame));
    };
    job.id = JobId(next_++);
    if (rows > 0) job.tile_rows = 0;
    EXPECT_TRUE(renderer_->make_room(job));
    EXPECT_TRUE(renderer_->submit(job, deliver));
    for (uint32_t row = 0; rows > 0 && row < (kHeight + 7) / 8; row += rows)
      EXPECT_TRUE(renderer_->resume(job.id, rows, deliver));
    return arrived.get_future().get();
  }
  // What a probe reads back of the frame, packed here.
  std::vector<uint64_t> expected(SampleCounts samples) const {
    auto probe = SurfaceProbe::create(device_options(), scene_);
    EXPECT_TRUE(probe);
    const auto frame = probe->render(job(samples).camera, kWidth, kHeight, {}, samples);
    EXPECT_TRUE(frame);
    return unpacked(PackedMask(frame->mask(), frame->valid_bits).view());
  }

  scenes::ScenePtr scene_;
  std::unique_ptr<Renderer> renderer_;
  uint64_t next_ = 0;
};

TEST_F(SoftFrames, HaveThePlanesOfTheirSamples) {
  for (const SampleCounts samples :
       {SampleCounts{1}, {4}, {16}, {1, Occlusion::full}, {4, Occlusion::half}, {1, Occlusion::half}, {1}}) {
    const Frame frame = render(job(samples));
    EXPECT_EQ(frame.grid.planes, planes_of(*scene_, samples).total());
    EXPECT_EQ(frame.words, expected(samples)) << int{samples.per_light} << ' ' << to_string(samples.occlusion);
    EXPECT_GT(frame.trace_ns, 0u);
  }
}

TEST_F(SoftFrames, InBandsAreThoseInOnePiece) {
  for (const SampleCounts samples : {SampleCounts{16}, {1, Occlusion::full}, {4, Occlusion::half}}) {
    const Frame whole = render(job(samples));
    for (const uint32_t rows : {1u, 3u, 7u}) EXPECT_EQ(render(job(samples), rows).words, whole.words) << rows;
  }
}

// The masks are the same while what is built for areas is not there yet, and with it.
TEST_F(SoftFrames, AreTracedByWhatIsBuiltForAreasWhenThatIsThere) {
  const uint64_t before = renderer_->footprint(kScene).memory_bytes;
  const std::vector<uint64_t> first = render(job(16)).words;
  const TimePoint end = Clock::now() + std::chrono::minutes(1);
  while (renderer_->footprint(kScene).memory_bytes == before && Clock::now() < end)
    EXPECT_EQ(render(job(16)).words, first);
  EXPECT_GT(renderer_->footprint(kScene).memory_bytes, before);
  EXPECT_EQ(render(job(16)).words, first);
}

TEST_F(SoftFrames, LightsThatAreNotTracedAreLitAndTheirOtherPlanesFree) {
  RenderJob some = job(16);
  some.untraced[0] = some.untraced[2] = true;  // of which one is directional
  const Frame frame = render(some), traced = render(job(16));
  const LightPlanes planes = planes_of(*scene_, 16);
  ASSERT_GT(planes.count(0), 1u);
  ASSERT_EQ(planes.count(2), 1u);
  const uint32_t tiles = frame.grid.tile_count();
  const auto class_of = [&](uint32_t plane, uint32_t tile) { return frame.classes[size_t{plane} * tiles + tile]; };
  for (uint32_t light = 0; light < planes.light_count(); ++light) {
    for (uint32_t i = 0; i < planes.count(light); ++i) {
      for (uint32_t tile = 0; tile < tiles; ++tile) {
        const uint32_t plane = planes.first(light) + i;
        if (some.untraced[light]) {
          ASSERT_EQ(class_of(plane, tile), i == 0 ? PackedClass::lit : PackedClass::free);
        } else {
          ASSERT_EQ(class_of(plane, tile), traced.classes[size_t{plane} * tiles + tile]) << light;
        }
      }
    }
  }
}

TEST_F(SoftFrames, LightsThatAreNotTracedLeaveOcclusionAsItIs) {
  for (const uint32_t per_light : {1u, 4u}) {
    const SampleCounts samples{per_light, Occlusion::full};
    RenderJob some = job(samples);
    some.untraced.set();
    const Frame none = render(some), all = render(job(samples));
    const size_t first = size_t{planes_of(*scene_, samples).first_of_occlusion()} * all.grid.tile_count();
    ASSERT_EQ(none.words.size(), all.words.size());
    EXPECT_NE(std::vector(none.words.begin(), none.words.begin() + static_cast<ptrdiff_t>(first)),
              std::vector(all.words.begin(), all.words.begin() + static_cast<ptrdiff_t>(first)));
    EXPECT_TRUE(std::equal(none.words.begin() + static_cast<ptrdiff_t>(first), none.words.end(),
                           all.words.begin() + static_cast<ptrdiff_t>(first)));
  }
}

}  // namespace
}  // namespace gnomon::test
