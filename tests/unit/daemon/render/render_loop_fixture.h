// A render loop with a fake renderer, on the test's own thread and clock.
#pragma once

#include <gtest/gtest.h>

#include "daemon/render/render_loop.h"
#include "tests/unit/daemon/render/fake_renderer.h"

namespace gnomon::daemon {

using namespace std::chrono_literals;
inline constexpr SceneId kScene{0};
inline constexpr TenantId kTenant{0};
inline constexpr SessionId kA{11}, kB{22}, kSilent{33};

class RenderLoopTest : public testing::Test, private FrameSink {
 protected:
  static constexpr uint32_t kSlots = 2;

  void SetUp() override {
    device_ = std::move(*RenderDevice::open(
        [this]() -> Result<std::unique_ptr<gpu::Renderer>> {
          ++renderers_made_;
          if (no_more_renderers_) return Error{"no device left"};
          auto made = std::make_unique<FakeRenderer>(slots_, 2, areas_);
          made->cpu = cpu_;
          fake_ = made.get();
          return std::unique_ptr<gpu::Renderer>(std::move(made));
        },
        inbox_));
    loop_ = std::make_unique<RenderLoop>(
        SharingPolicy{.policy = "round_robin", .frames_in_flight = kSlots, .tenants = {TenantShare{}}}, *device_,
        inbox_, metrics_, static_cast<FrameSink&>(*this));
    loop_->handle(SceneLoaded{{kScene, std::make_shared<scenes::Scene>(), 0, 0},
                              [](Result<gpu::SceneFootprint> made) { EXPECT_TRUE(made); }},
                  now_);
    for (const SessionId session : {kA, kB, kSilent}) open(session);
  }

  void TearDown() override {
    rendered_.clear();
    device_.reset();
  }

  void on_rendered(RenderedFrame frame) override { rendered_.push_back(std::move(frame)); }
  void on_encoded(EncodedFrame) override {}
  void on_degraded(const SessionDegraded& session) override { degraded_.push_back(session); }
  void on_lights(const LightsUpdate&) override {}

  // Opens a session of kTenant in kScene, of that size, with two lights, unless `grant` says otherwise.
  void open(SessionId session, SessionGrant grant = {.width = 16, .height = 16}) {
    if (grant.lights == 0) grant.lights = 2;
    loop_->handle(SessionOpened{.session = session, .grant = grant}, now_);
  }

  void view(SessionId session, uint32_t frame) {
    ViewRequest view{session, FrameId{frame}, {}, now_};
    view.camera.position[0] = static_cast<float>(frame);
    loop_->handle(view, now_);
  }

  // Starts what fits, handles what that put into the inbox, and so on, as the render thread does; takes 1 ms.
  void settle() {
    std::vector<RenderEvent> batch;
    do {
      loop_->start(now_);
      inbox_.take(batch, TimePoint::min());
      for (RenderEvent& event : batch) loop_->handle(std::move(event), now_);
    } while (!batch.empty());
    now_ += 1ms;
  }

  // How many frames a session gets within 2 s that asks all the time, of a device that takes 1 ms for each.
  size_t frames_in_2s(SessionId session) {
    const TimePoint begin = now_;
    size_t frames = 0;
    for (uint32_t frame = 1; now_ - begin < 2s; ++frame) {
      view(session, frame);
      settle();
      while (fake_->waiting() > 0) fake_->complete(1ms);
      frames += std::exchange(rendered_, {}).size();
      settle();
    }
    return frames;
  }

  std::vector<uint32_t> rendered_frames_of(SessionId session) {
    std::vector<uint32_t> frames;
    for (const RenderedFrame& frame : rendered_) {
      if (frame.meta.route.session == session) frames.push_back(frame.meta.route.frame.value);
    }
    return frames;
  }

  uint32_t slots_ = kSlots;
  TimePoint now_ = TimePoint(std::chrono::hours(1));
  Metrics metrics_{{"default", "other"}, {}, "test"};
  RenderInbox inbox_;
  int renderers_made_ = 0;
  bool no_more_renderers_ = false;
  bool cpu_ = false;         // whether the device is a CPU
  std::vector<bool> areas_;  // of its two lights, which are area lights
  FakeRenderer* fake_ = nullptr;
  std::unique_ptr<RenderDevice> device_;
  std::vector<RenderedFrame> rendered_;
  std::vector<SessionDegraded> degraded_;
  std::unique_ptr<RenderLoop> loop_;
};

}  // namespace gnomon::daemon
