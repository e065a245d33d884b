// Scenes in motion: at any time the masks are those of the scene frozen at that time, whatever moves.
#include <gtest/gtest.h>

#include <future>
#include <random>

#include "gpu/scene/resident_scene.h"
#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;
using namespace std::chrono_literals;
using scenes::SceneTime;

constexpr uint32_t kWidth = 100, kHeight = 60;

CameraView camera() { return look_at({0.5f, 0.6f, 2.4f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight); }

// The number of bits that may differ by the tracer's own rounding: none, except for the device's ray queries.
size_t allowed(const std::string& tracer, const Count& count) {
  return tracer == "ray_query" ? (count.lit + count.dark) / 1000 : 0;
}

void expect_exact(SurfaceProbe& probe, const scenes::Scene& scene, SceneTime time, const std::string& tracer,
                  const CameraView& view = camera()) {
  const auto frame = probe.render(view, kWidth, kHeight, time);
  ASSERT_TRUE(frame) << frame.error().message;
  const Count count = compare(*scenes::frozen_at(scene, time), view, *frame);
  EXPECT_LE(count.differing, allowed(tracer, count)) << tracer << " at " << time.count() << " us";
  EXPECT_GT(count.lit, 200u);
  EXPECT_GT(count.dark, 200u);
}

bool has_stage(const ProbedFrame& frame, std::string_view name) {
  return std::any_of(frame.timing.stages.begin(), frame.timing.stages.end(),
                     [&](const StageTime& stage) { return stage.pass == name; });
}

class InMotion : public testing::TestWithParam<WhatMoves> {};

TEST_P(InMotion, MasksAreThoseOfTheSceneStopped) {
  for (const std::string& tracer : tracers()) {
    for (uint32_t seed = 1; seed <= 3; ++seed) {
      const auto scene = swinging_soup(seed, GetParam());
      auto probe = SurfaceProbe::create(device_options(tracer), scene);
      ASSERT_TRUE(probe) << probe.error().message;
      std::mt19937 random(seed);
      std::uniform_int_distribution<int> time(0, 2'000'000);
      for (int i = 0; i < 4; ++i) expect_exact(*probe, *scene, SceneTime(time(random)), tracer);
    }
  }
}

TEST_P(InMotion, SurfacesAndCaresAreThoseOfTheSceneStopped) {
  const auto scene = swinging_soup(9, GetParam());
  for (const SceneTime time : {SceneTime(0), SceneTime(700ms)}) {
    auto moving = SurfaceProbe::create(device_options(), scene);
    auto stopped = SurfaceProbe::create(device_options(), scenes::frozen_at(*scene, time));
    ASSERT_TRUE(moving && stopped);
    const auto a = moving->render(camera(), kWidth, kHeight, time);
    const auto b = stopped->render(camera(), kWidth, kHeight);
    ASSERT_TRUE(a && b);
    size_t shown = 0, of_what_moves = 0;
    const size_t resting = moving->scene().triangle_count();
    for (size_t i = 0; i < a->samples.size(); ++i) {
      ASSERT_EQ(a->samples[i].position, b->samples[i].position) << i;
      ASSERT_EQ(a->samples[i].normal, b->samples[i].normal) << i;
      shown += a->samples[i].triangle != 0;
      of_what_moves += a->samples[i].triangle > resting;
    }
    EXPECT_GT(shown, 500u);
    EXPECT_EQ(of_what_moves > 50, GetParam().body);
    EXPECT_EQ(a->words, b->words);
    EXPECT_EQ(a->valid_bits, b->valid_bits);
    EXPECT_TRUE(has_stage(*a, "trace_moving"));
    EXPECT_FALSE(has_stage(*b, "trace_moving"));
    EXPECT_FALSE(has_stage(*b, "pose"));
  }
}

INSTANTIATE_TEST_SUITE_P(What, InMotion,
                         testing::Values(WhatMoves{true, false}, WhatMoves{false, true}, WhatMoves{true, true}),
                         [](const auto& test) {
                           return std::string(test.param.body ? "Body" : "") + (test.param.light ? "Light" : "");
                         });

// Many small bodies, so that most of what moves is left out for most tiles; near the origin and far from it, where floats are
// coarse; more lights than are looked at together.
scenes::ScenePtr swarm(uint32_t seed, uint32_t lights, glm::vec3 at) {
  auto scene = std::make_shared<scenes::Scene>(*triangle_soup(seed, 200, lights));
  scene->meshes.push_back(triangle_soup(seed + 100, 12, 1)->meshes[0]);
  for (glm::vec3& p : scene->meshes[0].primitives[0].positions) p += at;
  for (glm::vec3& p : scene->meshes[1].primitives[0].positions) p *= 0.15f;
  for (scenes::Light& light : scene->lights) light.position += at;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> around(-0.3f, 1.3f);
  const auto point = [&] { return glm::vec3(around(random), around(random), around(random)); };
  for (uint32_t body = 0; body < 30; ++body) {
    scene->moving_nodes.push_back(swing(at + point(), at + point()));
    scene->instances.push_back({1, glm::mat4(1.0f), body});
  }
  scene->period = 2s;
  scene->bounds = scenes::moved_bounds(*scene, {scene->bounds.min + at, scene->bounds.max + at});
  return scene;
}

class Swarm : public testing::TestWithParam<glm::vec3> {};

// Small pictures of much: tiles reach far, so that much of what their segments may meet is met by few of them.
TEST_P(Swarm, MasksAreThoseOfTheSceneStopped) {
  constexpr uint32_t kAcross = 24, kDown = 16;
  CameraView view = look_at({0.5f, 0.6f, 2.4f}, {0.5f, 0.5f, 0.5f}, 0.8f, kAcross, kDown);
  view.position += GetParam();
  for (const std::string& tracer : tracers()) {
    for (const uint32_t lights : {4u, 40u}) {
      const auto scene = swarm(lights, lights, GetParam());
      auto probe = SurfaceProbe::create(device_options(tracer), scene);
      ASSERT_TRUE(probe) << probe.error().message;
      Count all;
      for (int step = 0; step < 60; ++step) {
        const SceneTime time = 16ms * step;
        const auto frame = probe->render(view, kAcross, kDown, time);
        ASSERT_TRUE(frame) << frame.error().message;
        all += compare(*scenes::frozen_at(*scene, time), view, *frame);
      }
      EXPECT_LE(all.differing, allowed(tracer, all)) << tracer << ", " << lights << " lights";
      EXPECT_GT(all.lit, 1000u);
      EXPECT_GT(all.dark, 1000u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(At, Swarm, testing::Values(glm::vec3(0.0f), glm::vec3(300.0f, -200.0f, 90.0f)),
                         [](const auto& test) { return test.param.x == 0.0f ? "TheOrigin" : "FarFromTheOrigin"; });

// The shaft of a picture of one pixel is a line, and these bodies' boxes are flat: rounding must not part them.
TEST(Motion, FlatBodiesHideFromSinglePixels) {
  auto scene = std::make_shared<scenes::Scene>(*triangle_soup(3, 200, 4));
  scenes::Mesh flat = triangle_soup(4, 40, 1)->meshes[0];
  for (size_t i = 0; i < flat.primitives[0].positions.size(); ++i) {
    const size_t axis = i / 3 % 3;
    flat.primitives[0].positions[i][static_cast<int>(axis)] =
        flat.primitives[0].positions[i - i % 3][static_cast<int>(axis)];
  }
  scene->meshes.push_back(std::move(flat));
  scene->moving_nodes = {swing({0, 0, 0}, {0.3f, 0.2f, 0.1f})};
  scene->moving_nodes[0].channels.pop_back();  // its turn
  scene->instances.push_back({1, glm::mat4(1.0f), 0});
  scene->period = 2s;
  scene->bounds = scenes::moved_bounds(*scene, scene->bounds);
  auto probe = SurfaceProbe::create(device_options("bvh"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto point = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
  const auto stopped = scenes::frozen_at(*scene, 300ms);
  Count all;
  for (int i = 0; i < 400; ++i) {
    const CameraView view = look_at(3.0f * point() - 1.0f, point(), 0.01f, 1, 1);
    const auto frame = probe->render(view, 1, 1, 300ms);
    ASSERT_TRUE(frame) << frame.error().message;
    all += compare(*stopped, view, *frame);
  }
  EXPECT_EQ(all.differing, 0u);
  EXPECT_GT(all.lit, 100u);
  EXPECT_GT(all.dark, 100u);
}

// Triangles with an alpha test that move: they are looked up in the slot's part of the scene's buffers.
TEST(Motion, MaskedTrianglesMoveWithTheirHoles) {
  auto scene =
      std::make_shared<scenes::Scene>(*checks_over_floor(point_light({0, 3, 0}), 4, scenes::AlphaMode::mask));
  scene->moving_nodes = {swing({0, 0, 0}, {0.5f, 0.4f, -0.3f})};
  scene->period = 2s;
  for (scenes::Primitive& primitive : scene->meshes[0].primitives) {
    if (primitive.material != 1) continue;
    scene->meshes.push_back({"checks", {primitive}});
    primitive.triangles.clear();
  }
  ASSERT_EQ(scene->meshes.size(), 2u);
  scene->instances.push_back({1, glm::mat4(1.0f), 0});
  scene->bounds = scenes::moved_bounds(*scene, scene->bounds);
  const CameraView above = look_at({0, 2.5f, 2.5f}, {0, 0, 0}, 1.0f, kWidth, kHeight);
  for (const SceneTime time : {SceneTime(0), SceneTime(600ms), SceneTime(1s)}) {
    auto moving = SurfaceProbe::create(device_options("bvh"), scene);
    auto stopped = SurfaceProbe::create(device_options("bvh"), scenes::frozen_at(*scene, time));
    ASSERT_TRUE(moving && stopped);
    const auto a = moving->render(above, kWidth, kHeight, time);
    const auto b = stopped->render(above, kWidth, kHeight);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->words, b->words);
    EXPECT_TRUE(std::any_of(a->words.begin(), a->words.end(), [](uint64_t w) { return w != 0 && ~w != 0; }));
  }
}

// A slot keeps its frame's pose: neither another frame in flight nor a frame between its bands changes it.
TEST(Motion, FramesInFlightHaveTheirOwnTimes) {
  const auto scene = swinging_soup(4, {true, true});
  auto probe = SurfaceProbe::create(device_options(), scene);
  auto renderer = make_renderer(device_options());
  ASSERT_TRUE(probe && renderer);
  ASSERT_TRUE((*renderer)->make_resident(SceneId(0), scene));
  std::vector<std::promise<std::vector<uint64_t>>> arrivals(3);
  const auto deliver = [&](size_t i) {
    return [&arrivals, i](FrameDone done) {
      if (done.complete) arrivals[i].set_value(unpacked(done.mask.mask()));
    };
  };
  const auto job = [&](size_t i) {
    return RenderJob{JobId(i), SceneId(0), camera(), kWidth, kHeight, SceneTime(300'000 * static_cast<int>(i))};
  };
  RenderJob in_bands = job(0);
  in_bands.tile_rows = 0;  // rasterised alone
  ASSERT_TRUE((*renderer)->submit(in_bands, deliver(0)));
  ASSERT_TRUE((*renderer)->submit(job(1), deliver(1)));
  ASSERT_TRUE((*renderer)->submit(job(2), deliver(2)));
  ASSERT_TRUE((*renderer)->resume(JobId(0), 5, deliver(0)));
  ASSERT_TRUE((*renderer)->resume(JobId(0), 100, deliver(0)));
  for (size_t i = 0; i < arrivals.size(); ++i) {
    const auto frame = probe->render(camera(), kWidth, kHeight, job(i).time);
    ASSERT_TRUE(frame);
    EXPECT_EQ(arrivals[i].get_future().get(), unpacked(PackedMask(frame->mask(), frame->valid_bits).view())) << i;
  }
}

TEST(Motion, LightsThatWereMovedAreExactAndRestAgainWhenRebuilt) {
  for (const std::string& tracer : tracers()) {
    auto scene = std::make_shared<scenes::Scene>(*triangle_soup(5, 300, 4));
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    scene->lights[0].position += glm::vec3(0.2f, 0.1f, -0.1f);
    scene->lights[2].direction = glm::normalize(glm::vec3(0.3f, -0.8f, 0.2f));
    ASSERT_TRUE(probe->set_lights(scene->lights));
    expect_exact(*probe, *scene, {}, tracer);
    const auto moved = probe->render(camera(), kWidth, kHeight);
    ASSERT_TRUE(moved);
    EXPECT_EQ(has_stage(*moved, "trace_moving"), tracer == "light_buffer");
    ASSERT_TRUE(probe->rebuild());
    const auto rested = probe->render(camera(), kWidth, kHeight);
    ASSERT_TRUE(rested);
    EXPECT_FALSE(has_stage(*rested, "trace_moving"));
    EXPECT_EQ(moved->words, rested->words) << tracer;
    EXPECT_EQ(moved->valid_bits, rested->valid_bits) << tracer;
  }
}

}  // namespace
}  // namespace gnomon::test
