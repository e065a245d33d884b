#include "daemon/render/device_thread.h"

#include <algorithm>

#include "common/within_memory.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kReportInterval = 1s;
constexpr auto kLongestBuild = 5min;  // to rebuild a device with all its scenes

// Whether the batch may have changed which scenes are resident or how much of their light buffers is built.
bool scenes_may_differ(const std::vector<RenderEvent>& batch) {
  return std::any_of(batch.begin(), batch.end(), [](const RenderEvent& event) {
    return std::holds_alternative<BackgroundDone>(event) || std::holds_alternative<SceneLoaded>(event);
  });
}

}  // namespace

Result<void> DeviceThread::start(RendererFactory factory, const SharingPolicy& sharing,
                                 const SceneMotion::Settings& motion, FrameSink& sink) {
  auto device = RenderDevice::open(std::move(factory), inbox_, number_);
  if (!device) return device.error();
  device_ = std::move(*device);
  const gpu::DeviceInfo info = device_->renderer().info();
  log::info("device open", {{"number", number_},
                            {"device", info.name},
                            {"driver", info.driver},
                            {"tracer", info.tracer},
                            {"raster", info.raster}});
  info_.publish(info);
  loop_ = std::make_unique<RenderLoop>(sharing, *device_, inbox_, metrics_, sink);
  loop_->motion().configure(motion);
  up_ = true;
  thread_ = std::thread([this] { render(); });
  return {};
}

void DeviceThread::stop() {
  inbox_.push(StopRendering{});
  if (thread_.joinable()) thread_.join();
}

void DeviceThread::render() {
  std::vector<RenderEvent> batch;
  while (true) {
    show_life(batch);
    if (tell_change()) {  // sessions may move away before the device is rebuilt, which takes long
      inbox_.take(batch, TimePoint::min());
      handle(batch);
    }
    done_or_dropped("the start of frames", [&] {
      loop_->start(Clock::now());
      if (!loop_->failure() && scenes_may_differ(batch)) scenes_.publish(loop_->motion().report());
    });
    tell_change();
    if (loop_->finished()) break;
    done_or_dropped("figures of a device", [&] { publish(Clock::now()); });
    inbox_.take(batch, std::min(next_report_, loop_->wake_at()));
    handle(batch);
  }
  heartbeat_.end();
  if (!loop_->failure()) return;
  owner_.device_failed(number_, *loop_->failure());
  refuse_the_rest(*loop_->failure());
}

// With frames in flight, progress means that a frame was completed. Rebuilding a device takes as long as its scenes.
void DeviceThread::show_life(const std::vector<RenderEvent>& done) {
  const bool moved = std::any_of(done.begin(), done.end(), [](const RenderEvent& event) {
    return std::holds_alternative<JobFinished>(event) || std::holds_alternative<SlotFreed>(event);
  });
  if (moved || loop_->frames_out() == 0) heartbeat_.beat();
  if (!loop_->device_up()) heartbeat_.excuse_until(Clock::now() + kLongestBuild);
}

void DeviceThread::handle(std::vector<RenderEvent>& batch) {
  for (RenderEvent& event : batch) {
    done_or_dropped("an event of a device", [&] { loop_->handle(std::move(event), Clock::now()); });
  }
}

bool DeviceThread::tell_change() {
  const bool up = loop_->device_up() && !loop_->failure();
  if (up_.exchange(up) == up) return false;
  done_or_dropped("a change of a device", [&] { owner_.device_changed(number_, up); });
  return true;
}

void DeviceThread::publish(TimePoint now) {
  if (now < next_report_) return;
  next_report_ = now + kReportInterval;
  loop_->review_sessions(kReportInterval);
  shares_.publish(loop_->shares());
  costs_.publish(loop_->costs());
  scenes_.publish(loop_->motion().report());
  owner_.device_reported();
}

// Closes the inbox and answers the scenes and questions for room in it with the error.
void DeviceThread::refuse_the_rest(const Error& why) {
  inbox_.close();
  std::vector<RenderEvent> batch;
  inbox_.take(batch, TimePoint::min());
  for (const RenderEvent& event : batch) {
    if (const auto* arrived = std::get_if<SceneLoaded>(&event)) arrived->resident(why);
    if (const auto* asked = std::get_if<CapacityRequested>(&event)) asked->answer(why);
  }
}

}  // namespace gnomon::daemon
