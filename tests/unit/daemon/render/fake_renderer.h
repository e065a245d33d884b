// A renderer without a GPU, whose masks identify the view that they were rendered for.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "common/light_planes.h"
#include "gpu/renderer.h"

namespace gnomon::daemon {

// The mask word that the fake renderer returns for a camera; it depends on everything that identifies the view.
inline uint64_t fake_word(const gpu::CameraView& camera, size_t word) {
  const auto bits = static_cast<uint64_t>(camera.position.x * 1000.0f + 0.5f);
  return (bits + 1) * 0x9e3779b97f4a7c15ull ^ (uint64_t{word} << 7);
}

// Frames are completed when the test says so. Any thread.
class FakeRenderer : public gpu::Renderer {
 public:
  struct Waiting {
    gpu::RenderJob job;
    std::function<void(gpu::FrameDone)> on_done;
    bool last = true;   // of the frame's bands
    uint32_t rows = 0;  // of tiles, that it traces
    bool first = true;
  };

  // `areas`: for each light, whether it is an area light; if empty, none is.
  explicit FakeRenderer(uint32_t slots, uint32_t lights = 2, std::vector<bool> areas = {})
      : areas_(std::move(areas)), free_(slots) {
    areas_.resize(lights);
  }

  gpu::DeviceInfo info() const override {
    gpu::DeviceInfo info;
    info.name = "fake";
    info.on_cpu = cpu;
    info.light_buffer_room = light_buffer_room;
    return info;
  }
  void on_slot_freed(std::function<void()> freed) override { freed_ = std::move(freed); }
  // To be set before the renderer is used.
  bool cpu = false;
  uint64_t light_buffer_room = 0;

  Result<void> make_resident(SceneId id, const scenes::ScenePtr&) override {
    if (takes_no_scenes) return Error{"no memory for it"};
    std::lock_guard lock(mutex_);
    resident_.insert(id);
    return {};
  }
  std::atomic<bool> takes_no_scenes = false;  // any thread
  void evict(SceneId id) override {
    std::lock_guard lock(mutex_);
    resident_.erase(id);
  }

  // Background work is done at once or, if the test holds it back, in a later call of finish_background. Render thread.
  void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
             std::function<void()>) override {
    ++brought;
    beside(holds_scenes, [this, id, scene, resident] { resident(make_resident(id, scene)); });
  }
  void rebuild_lights(SceneId, std::function<void(Result<void>)> settled, std::function<void()>) override {
    beside(holds_builds, [this, settled] {
      state_of_lights.unbuilt = 0;
      settled({});
    });
  }
  void set_lights(SceneId, std::vector<scenes::Light>, std::function<void(Result<void>)> changed,
                  std::function<void()>) override {
    changed({});
  }
  void finish_background() override {
    if (holds_scenes || holds_builds) return;
    for (const auto& each : std::exchange(background_, {})) each();
  }
  gpu::LightState light_state(SceneId) const override { return state_of_lights; }
  gpu::LightState state_of_lights;                               // of every scene
  std::atomic<bool> holds_scenes = false, holds_builds = false;  // any thread
  int brought = 0;

  uint32_t free_slots() const override {
    std::lock_guard lock(mutex_);
    return free_;
  }

  Result<void> make_room(const gpu::RenderJob& job) override {
    asked_room = job;
    if (job.width * job.height > most_pixels) return Error{"no memory, says the test"};
    return {};
  }

  Result<void> submit(const gpu::RenderJob& job, std::function<void(gpu::FrameDone)> on_done) override {
    std::lock_guard lock(mutex_);
    if (refuse_submits) return Error{"refused by the test"};
    if (job.width * job.height > most_pixels) return Error{"no memory, says the test"};
    if (free_ == 0 || !resident_.contains(job.scene)) std::abort();  // a broken precondition is a bug
    --free_;
    const uint32_t all = TileGrid{job.width, job.height, 0}.tiles_y();
    const uint32_t rows = std::min(job.tile_rows.value_or(all), all);
    const bool last = rows == all;
    if (!last) begun_[job.id] = job;
    waiting_.push_back({job, std::move(on_done), last, rows, true});
    changed_.notify_all();
    return {};
  }

  Result<void> resume(JobId id, uint32_t rows, std::function<void(gpu::FrameDone)> on_done) override {
    std::lock_guard lock(mutex_);
    const auto found = begun_.find(id);
    if (refuse_submits || found == begun_.end()) return Error{"refused"};
    gpu::RenderJob& job = found->second;
    *job.tile_rows += rows;
    const bool last = *job.tile_rows >= TileGrid{job.width, job.height, 0}.tiles_y();
    waiting_.push_back({job, std::move(on_done), last, rows, false});
    if (last) begun_.erase(found);
    changed_.notify_all();
    return {};
  }
  void abandon(JobId id) override {
    {
      std::lock_guard lock(mutex_);
      if (begun_.erase(id) == 0) return;
    }
    free_slot();
  }
  size_t begun() const {
    std::lock_guard lock(mutex_);
    return begun_.size();
  }

  size_t waiting() const {
    std::lock_guard lock(mutex_);
    return waiting_.size();
  }
  // Completes the oldest submit as one that the driver had no memory to start.
  void refuse_to_start() { complete({}, false, std::nullopt, true); }
  gpu::RenderJob job(size_t index) const {
    std::lock_guard lock(mutex_);
    return waiting_.at(index).job;
  }
  bool begins(size_t index) const {
    std::lock_guard lock(mutex_);
    return waiting_.at(index).first;
  }
  uint32_t rows(size_t index) const {
    std::lock_guard lock(mutex_);
    return waiting_.at(index).rows;
  }
  std::set<SceneId> resident() const {
    std::lock_guard lock(mutex_);
    return resident_;
  }

  // Completes the oldest submit. The slot is free again when the lease is dropped.
  // `trace_time`: the part of its time that grows with the traced bits; nullopt: all of it.
  void complete(std::chrono::nanoseconds gpu_time = std::chrono::milliseconds(1), bool lost = false,
                std::optional<std::chrono::nanoseconds> trace_time = std::nullopt, bool out_of_memory = false) {
    Waiting frame;
    {
      std::lock_guard lock(mutex_);
      frame = std::move(waiting_.front());
      waiting_.pop_front();
    }
    gpu::FrameDone done;
    done.id = frame.job.id;
    done.gpu_ns = static_cast<uint64_t>(gpu_time.count());
    done.trace_ns = static_cast<uint64_t>(trace_time.value_or(gpu_time).count());
    if (frame.first) frame_gpu_ns_[frame.job.id] = 0;
    done.frame_gpu_ns = frame_gpu_ns_[frame.job.id] += done.gpu_ns;
    done.completed_at = Clock::now();
    done.device_lost = lost;
    done.out_of_memory = out_of_memory;
    done.complete = frame.last;
    if (!frame.last) return frame.on_done(std::move(done));
    frame_gpu_ns_.erase(frame.job.id);
    done.mask = lost || out_of_memory ? gpu::FrameLease({}, [this] { free_slot(); }) : answer(frame.job);
    frame.on_done(std::move(done));
  }

  uint32_t most_pixels = UINT32_MAX;  // of a frame for which there is memory
  gpu::RenderJob asked_room;          // what room was asked for last
  bool refuse_submits = false;        // to be set before the renderer is used, or on the thread that submits

 private:
  void beside(bool hold, std::function<void()> done) {
    if (!hold) return done();
    background_.push_back(std::move(done));
  }
  std::vector<std::function<void()>> background_;

 protected:
  gpu::FrameLease answer(const gpu::RenderJob& job) {
    const LightPlanes planes(areas_, job.samples);
    const TileGrid grid{job.width, job.height, planes.total()};
    std::vector<uint64_t> words(grid.word_count());
    for (size_t i = 0; i < words.size(); ++i) words[i] = fake_word(job.camera, i);
    std::vector<uint64_t> care(words.size(), ~uint64_t{0});
    const size_t tiles = grid.tile_count();
    for (uint32_t light = 0; light < planes.light_count(); ++light)
      for (uint32_t plane = planes.first(light) + 1; plane < planes.first(light) + planes.count(light); ++plane)
        for (size_t i = 0; i < tiles; ++i) care[plane * tiles + i] = ~words[planes.first(light) * tiles + i];
    auto packed = std::make_shared<PackedMask>(TileMaskView{grid, words}, care);
    return gpu::FrameLease(packed->view(), [this, packed] { free_slot(); });
  }

  void free_slot() {
    {
      std::lock_guard lock(mutex_);
      ++free_;
    }
    if (freed_) freed_();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> waiting_;

 private:
  std::vector<bool> areas_;
  uint32_t free_;
  std::function<void()> freed_;
  std::set<SceneId> resident_;
  std::map<JobId, gpu::RenderJob> begun_;
  std::map<JobId, uint64_t> frame_gpu_ns_;  // of the bands so far; used by the thread that completes
};

// Completes every submit on a completion thread of its own, each after `delay`. `lose`: when it is true, the device is
// lost with the next submit.
class SelfRunningFakeRenderer final : public FakeRenderer {
 public:
  SelfRunningFakeRenderer(uint32_t slots, uint32_t lights, std::chrono::milliseconds delay,
                          std::shared_ptr<std::atomic<bool>> lose = std::make_shared<std::atomic<bool>>(false),
                          std::vector<bool> areas = {})
      : FakeRenderer(slots, lights, std::move(areas)),
        lose_(std::move(lose)),
        thread_([this, delay] { run(delay); }) {}

  ~SelfRunningFakeRenderer() override {
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

 private:
  void run(std::chrono::milliseconds delay) {
    while (true) {
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
      }
      std::this_thread::sleep_for(delay);
      complete(delay, lose_->exchange(false));
    }
  }

  const std::shared_ptr<std::atomic<bool>> lose_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace gnomon::daemon
