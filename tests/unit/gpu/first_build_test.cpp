// A scene is served before the tracer's build for its lights has ended, and by its result as soon as it has: every
// frame before, during and after the change equals that of a plain hierarchy, bit for bit.
#include <gtest/gtest.h>

#include <condition_variable>
#include <future>
#include <mutex>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr SceneId kScene{1};
constexpr uint32_t kWidth = 120, kHeight = 80, kLights = 4;

// Notifies the owner of a renderer when work beside the frames has ended.
class Bell {
 public:
  std::function<void()> ring() {
    return [this] {
      std::lock_guard lock(mutex_);
      rung_ = true;
      heard_.notify_all();
    };
  }
  void wait() {
    std::unique_lock lock(mutex_);
    heard_.wait(lock, [this] { return std::exchange(rung_, false); });
  }

 private:
  std::mutex mutex_;
  std::condition_variable heard_;
  bool rung_ = false;
};

struct Words {
  std::vector<uint64_t> masks;
  bool by_hierarchy = false;
};

class FirstBuild : public testing::Test {
 protected:
  void SetUp() override {
    if (std::find(tracers_.begin(), tracers_.end(), "light_buffer") == tracers_.end())
      GTEST_SKIP() << "the device has no tracer that builds for lights";
    renderer_ = renderer("light_buffer", false);
    plain_ = renderer("bvh", true);
    ASSERT_TRUE(plain_->make_resident(kScene, scene_));
  }

  static std::unique_ptr<Renderer> renderer(const std::string& tracer, bool wait) {
    RendererOptions options = full_size_options(tracer);
    options.wait_for_builds = wait;
    auto made = make_renderer(options);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }

  void bring() {
    Result<void> resident{Error{"not yet"}};
    renderer_->bring(
        kScene, scene_, [&](Result<void> made) { resident = made; }, bell_.ring());
    bell_.wait();
    renderer_->finish_background();
    ASSERT_TRUE(resident) << resident.error().message;
  }

  static RenderJob job(uint64_t id) {
    const float turn = 0.7f * static_cast<float>(id);
    const glm::vec3 eye(0.5f + 2 * std::cos(turn), 0.6f, 0.5f + 2 * std::sin(turn));
    return {JobId(id), kScene, look_at(eye, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight), kWidth, kHeight};
  }

  static std::function<void(FrameDone)> deliver(std::promise<Words>& words) {
    return [&words](FrameDone done) {
      if (!done.complete) return;
      const bool moving = std::any_of(done.stages.begin(), done.stages.end(),
                                      [](const StageTime& stage) { return stage.pass == "trace_moving"; });
      words.set_value({unpacked(done.mask.mask()), moving});
    };
  }

  static Words frame(Renderer& renderer, uint64_t id) {
    std::promise<Words> words;
    EXPECT_TRUE(renderer.submit(job(id), deliver(words)));
    return words.get_future().get();
  }

  const std::vector<std::string> tracers_ = tracers();
  // More triangles than a short build, which is done at once, may have.
  const scenes::ScenePtr scene_ = triangle_soup(7, 9000, kLights);
  Bell bell_;
  std::unique_ptr<Renderer> renderer_, plain_;
};

TEST_F(FirstBuild, EveryFrameIsExactBeforeDuringAndAfterIt) {
  bring();
  EXPECT_EQ(renderer_->light_state(kScene).unbuilt, kLights);
  uint64_t id = 0;
  const Words first = frame(*renderer_, id);
  EXPECT_TRUE(first.by_hierarchy);
  EXPECT_EQ(first.masks, frame(*plain_, id).masks);

  std::promise<Words> in_bands;
  RenderJob begun = job(1000);
  begun.tile_rows = 3;
  ASSERT_TRUE(renderer_->submit(begun, deliver(in_bands)));

  std::optional<Result<void>> settled;
  renderer_->rebuild_lights(
      kScene, [&](Result<void> built) { settled = built; }, bell_.ring());
  EXPECT_EQ(renderer_->build_progress(kScene).lights.size(), kLights);
  while (!settled) {
    ++id;
    ASSERT_EQ(frame(*renderer_, id).masks, frame(*plain_, id).masks) << "frame " << id;
    renderer_->finish_background();
  }
  ASSERT_TRUE(*settled) << settled->error().message;
  EXPECT_GT(id, 1u);
  EXPECT_TRUE(renderer_->build_progress(kScene).lights.empty());
  EXPECT_EQ(renderer_->light_state(kScene).resting, kLights);

  ASSERT_TRUE(renderer_->resume(JobId(1000), 100, deliver(in_bands)));
  const Words across = in_bands.get_future().get();
  EXPECT_TRUE(across.by_hierarchy) << "a frame is answered by one of the two, never by both";
  EXPECT_EQ(across.masks, frame(*plain_, 1000).masks);

  for (const uint64_t end = id + 5; id < end; ++id) {
    const Words after = frame(*renderer_, id);
    EXPECT_FALSE(after.by_hierarchy);
    EXPECT_EQ(after.masks, frame(*plain_, id).masks);
  }
}

TEST_F(FirstBuild, ALightThatIsChangedMeanwhileIsExactToo) {
  bring();
  std::optional<Result<void>> settled;
  renderer_->rebuild_lights(
      kScene, [&](Result<void> built) { settled = built; }, bell_.ring());
  std::vector<scenes::Light> lights = scene_->lights;
  lights[1].position += glm::vec3(0.2f, -0.1f, 0.3f);
  bool changed = false;
  renderer_->set_lights(
      kScene, lights, [&](Result<void> done) { changed = done.has_value(); }, bell_.ring());
  ASSERT_TRUE(changed) << "the hierarchy is there: nothing to wait for";
  plain_->set_lights(
      kScene, lights, [](Result<void> done) { EXPECT_TRUE(done); }, [] {});
  EXPECT_EQ(frame(*renderer_, 1).masks, frame(*plain_, 1).masks);
  while (!settled) {
    bell_.wait();
    renderer_->finish_background();
  }
  ASSERT_TRUE(*settled);
  EXPECT_EQ(renderer_->light_state(kScene).moving, 1u);
  EXPECT_EQ(renderer_->light_state(kScene).resting, kLights - 1);
  const Words mixed = frame(*renderer_, 2);
  EXPECT_TRUE(mixed.by_hierarchy);
  EXPECT_EQ(mixed.masks, frame(*plain_, 2).masks);
}

TEST_F(FirstBuild, ASceneThatLeavesEndsItsBuild) {
  bring();
  std::optional<Result<void>> settled;
  renderer_->rebuild_lights(
      kScene, [&](Result<void> built) { settled = built; }, bell_.ring());
  renderer_->evict(kScene);
  EXPECT_TRUE(renderer_->build_progress(kScene).lights.empty());
  while (!settled) {
    bell_.wait();
    renderer_->finish_background();
  }
  EXPECT_FALSE(*settled);
  bring();
  EXPECT_EQ(frame(*renderer_, 3).masks, frame(*plain_, 3).masks);
}

// A short build is done at once, without frames that are traced by a hierarchy.
TEST_F(FirstBuild, ASmallSceneIsBuiltAtOnce) {
  const auto small = triangle_soup(3, 300, 2);
  renderer_->bring(
      kScene, small, [](Result<void> made) { EXPECT_TRUE(made); }, bell_.ring());
  bell_.wait();
  renderer_->finish_background();
  EXPECT_EQ(renderer_->light_state(kScene).resting, 2u);
  EXPECT_FALSE(frame(*renderer_, 1).by_hierarchy);
}

}  // namespace
}  // namespace gnomon::test
