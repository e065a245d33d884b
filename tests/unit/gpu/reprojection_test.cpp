// Prediction by reprojection: what was seen keeps its bits, what was hidden or outside is lit by every light.
#include "gpu/picture/reprojection.h"

#include <gtest/gtest.h>

#include "gpu/picture/reference_view.h"
#include "scenes/loader.h"
#include "tests/unit/gpu/embree_oracle.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 320, kHeight = 180;

struct Seen {
  SurfaceProbe probe;
  std::unique_ptr<ReferenceView> view;
  Reprojection* reprojection = nullptr;
  ProbedFrame before;
  SeenMasks masks;

  Seen(const scenes::ScenePtr& scene, const CameraView& camera)
      : probe(SurfaceProbe::create(device_options("bvh"), scene).value()),
        view(ReferenceView::create(device_options(), scene).value()),
        reprojection(view->reprojection().value()),
        before(look(camera)),
        masks(reprojection->see(camera, before.mask(), {}).value()) {}
  ProbedFrame look(const CameraView& camera) { return probe.render(camera, kWidth, kHeight).value(); }
  std::vector<uint32_t> sources(const CameraView& camera) {
    const RasterView raster = reprojection->rasterise(camera, kWidth, kHeight, {}).value();
    const auto found = reprojection->sources(raster, masks.raster).value();
    return {found.begin(), found.end()};
  }
  std::vector<uint64_t> predicted(const CameraView& camera) {
    return masks_by_sources(before.mask(), sources(camera), kWidth, kHeight);
  }
};

struct Tally {
  size_t bits = 0, wrong = 0, falsely_dark = 0;
};

// Of the bits that matter, where `counts` says so.
template <class Counts>
Tally compare(const ProbedFrame& fresh, const std::vector<uint64_t>& predicted, Counts counts) {
  Tally tally;
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      if (!counts(x, y)) continue;
      for (uint32_t light = 0; light < fresh.grid.planes; ++light) {
        if (!fresh.care().lit(x, y, light)) continue;
        const bool is = fresh.mask().lit(x, y, light), said = TileMaskView{fresh.grid, predicted}.lit(x, y, light);
        ++tally.bits;
        tally.wrong += is != said;
        tally.falsely_dark += is && !said;
      }
    }
  return tally;
}

CameraView eye_at(glm::vec3 eye) { return look_at(eye, {0, 0.3f, 0}, 0.9f, kWidth, kHeight); }

TEST(ReprojectionTest, TheSameViewGivesTheSameBits) {
  Seen seen(square_over_floor(point_light({0.7f, 3.0f, -0.4f})), eye_at({3, 4, 5}));
  const auto sources = seen.sources(eye_at({3, 4, 5}));
  for (size_t i = 0; i < sources.size(); ++i)
    ASSERT_EQ(sources[i], seen.before.samples[i].triangle ? i + 1 : 0) << i;
  EXPECT_EQ(compare(seen.before, seen.predicted(eye_at({3, 4, 5})), [](auto, auto) { return true; }).wrong, 0u);
}

// Hidden from `eye` by more than `margin` around the point: every probe beside it, in its plane, is hidden too.
bool hidden(const EmbreeOracle& oracle, const SurfaceSample& at, glm::vec3 eye, float margin) {
  const glm::vec3 aside =
      glm::normalize(glm::cross(at.normal, std::abs(at.normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0)));
  const glm::vec3 along = glm::cross(at.normal, aside);
  for (const glm::vec3 offset : {glm::vec3(0), aside, -aside, along, -along})
    if (!oracle.occluded(at.position + at.normal * 1e-4f + margin * offset, eye)) return false;
  return true;
}

// The eye moves sideways, so that the floor that the square hid comes out from behind it.
TEST(ReprojectionTest, DisoccludedPointsAreNeverFalselyDark) {
  const auto scene = square_over_floor(point_light({0.7f, 3.0f, -0.4f}));
  const EmbreeOracle oracle(scene, true);
  size_t disoccluded = 0;
  for (const glm::vec3 from : {glm::vec3(3, 4, 5), glm::vec3(1, 2.2f, 3), glm::vec3(-2, 1.5f, 4)}) {
    Seen seen(scene, eye_at(from));
    const CameraView now = eye_at(from + glm::vec3(1.5f, 0.3f, -0.8f));
    const ProbedFrame fresh = seen.look(now);
    const auto predicted = seen.predicted(now);
    const float pixel = 2 * now.tan_up / kHeight;
    const auto was_hidden = [&](uint32_t x, uint32_t y) {
      const SurfaceSample& at = fresh.samples[size_t{y} * kWidth + x];
      return at.triangle != 0 && hidden(oracle, at, from, 3 * pixel * glm::distance(at.position, from));
    };
    const Tally tally = compare(fresh, predicted, was_hidden);
    disoccluded += tally.bits;
    EXPECT_EQ(tally.falsely_dark, 0u);
    // And the rest is mostly right: the floor and the square are planes.
    const Tally all = compare(fresh, predicted, [&](auto x, auto y) { return !was_hidden(x, y); });
    EXPECT_LT(static_cast<double>(all.wrong), 0.05 * static_cast<double>(all.bits));
  }
  EXPECT_GT(disoccluded, 300u);
}

TEST(ReprojectionTest, OutsideTheSeenViewIsLit) {
  Seen seen(square_over_floor(point_light({0.1f, 1.5f, 0.1f})),
            look_at({0, 3, 4}, {6, 0, 0}, 0.5f, kWidth, kHeight));
  const CameraView now = look_at({0, 3, 4}, {-6, 0, 0}, 0.5f, kWidth, kHeight);
  for (const uint64_t word : seen.predicted(now)) EXPECT_EQ(word, ~uint64_t{0});
}

TEST(ReprojectionTest, ABorderLeavesLessOutside) {
  const auto scene = square_over_floor(point_light({0.7f, 3.0f, -0.4f}));
  SurfaceProbe probe = SurfaceProbe::create(device_options("bvh"), scene).value();
  auto view = ReferenceView::create(device_options(), scene).value();
  const CameraView plain = eye_at({1, 2.2f, 3}), now = eye_at({1.3f, 2.2f, 2.8f});
  size_t unseen[2];
  for (const uint32_t border : {0u, 1u}) {
    CameraView camera = plain;  // 64x36 more pixels of the same size, more of them to the right
    const uint32_t width = kWidth + 64 * border, height = kHeight + 36 * border;
    const float pixel = 2 * plain.tan_up / kHeight;
    camera.tan_left += pixel * 8 * border;
    camera.tan_right += pixel * 56 * border;
    camera.tan_up += pixel * 18 * border;
    camera.tan_down += pixel * 18 * border;
    const ProbedFrame frame = probe.render(camera, width, height).value();
    Reprojection& reprojection = *view->reprojection().value();
    const SeenMasks seen = reprojection.see(camera, frame.mask(), {}).value();
    const RasterView raster = reprojection.rasterise(now, kWidth, kHeight, {}).value();
    const auto sources = reprojection.sources(raster, seen.raster).value();
    unseen[border] = static_cast<size_t>(std::count(sources.begin(), sources.end(), 0u));
  }
  EXPECT_LT(unseen[1], unseen[0]);
}

// The picture is the one that the predicted masks make.
TEST(ReprojectionTest, PicturesAreShadedWithTheSameBits) {
  Seen seen(square_over_floor(point_light({0.7f, 3.0f, -0.4f})), eye_at({3, 4, 5}));
  const CameraView now = eye_at({3.5f, 3.9f, 4.6f});
  const auto predicted = seen.predicted(now);
  const auto direct = seen.view->predict(now, kWidth, kHeight, seen.masks);
  const auto by_mask = seen.view->render(now, kWidth, kHeight, {seen.before.grid, predicted});
  ASSERT_TRUE(direct && by_mask);
  EXPECT_EQ(direct->rgba, by_mask->rgba);
}

TEST(ReprojectionTest, RefusesAMaskOfAnotherShape) {
  Seen seen(square_over_floor(point_light({0.7f, 3.0f, -0.4f})), eye_at({3, 4, 5}));
  const TileGrid other{kWidth, kHeight, 2};
  const std::vector<uint64_t> words(other.word_count());
  EXPECT_FALSE(seen.reprojection->see(eye_at({3, 4, 5}), {other, words}, {}));
}

}  // namespace
}  // namespace gnomon::test
