#include "gpu/vulkan_renderer.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <thread>

#include "common/freed_memory.h"
#include "common/inbox.h"
#include "gpu/frame/lanes.h"
#include "gpu/passes/passes.h"
#include "gpu/raster_choice.h"
#include "gpu/scene/background.h"
#include "gpu/scene/light_builds.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {
namespace {

// What leases share with the renderer and keep alive after it.
struct SlotPool {
  SlotPool(DevicePtr d, std::unique_ptr<Tracer> t, std::string r, Lanes l, Built b)
      : device(std::move(d)), tracer(std::move(t)), raster(std::move(r)), built(b), lanes(std::move(l)) {
    for (size_t i = 0; i < lanes.slots(); ++i) free.push_back(i);
  }

  uint32_t free_count() const {
    std::lock_guard lock(mutex);
    return static_cast<uint32_t>(free.size());
  }
  void give_back(size_t slot) {
    std::lock_guard lock(mutex);
    free.push_back(slot);
  }
  // The same at the end of a lease, which is reported.
  void release(size_t slot) {
    give_back(slot);
    if (freed) freed();
  }
  size_t take() {
    std::lock_guard lock(mutex);
    const size_t slot = free.back();
    free.pop_back();
    return slot;
  }

  DevicePtr device;
  std::unique_ptr<Tracer> tracer;
  std::string raster;
  Built built;                  // of a scene, before it is resident
  Lanes lanes;                  // the render loop's
  std::function<void()> freed;  // constant once a frame was submitted
  mutable std::mutex mutex;
  std::vector<size_t> free;
};

constexpr uint64_t kNeverStarted = UINT64_MAX;

// One submit: a frame, or a band of one. Without on_done: only gives its slot back.
struct InFlight {
  JobId id;
  size_t slot = 0;
  Lane* lane = nullptr;
  VkQueryPool timestamps = VK_NULL_HANDLE;
  bool first = true, last = true;
  uint64_t timeline = kNeverStarted;
  TileGrid grid;
  std::function<void(FrameDone)> on_done;
  bool out_of_memory = false;  // why it was never started
};

// A frame of which not all rows were submitted.
struct Begun {
  size_t slot = 0;
  Lane* lane = nullptr;
  SceneId scene;
  TileGrid grid;
  uint32_t next_row = 0;
  bool holed = false;  // one of its bands was never started
};

// One queue of the device: what waits to be started on it, and who waits for its end. Slots have their queue for ever.
struct Line {
  std::vector<InFlight> pending;  // submitted, not started
  std::vector<VkCommandBuffer> commands;
  Inbox<InFlight> in_flight;
  std::thread completion;
};

class VulkanRenderer : public Renderer {
 public:
  explicit VulkanRenderer(std::shared_ptr<SlotPool> pool)
      : pool_(std::move(pool)), slot_gpu_ns_(pool_->lanes.slots()), lines_(pool_->device->queue_count()) {
    for (Line& line : lines_) line.completion = std::thread([this, &line] { complete(line); });
  }
  ~VulkanRenderer() override {
    start_pending();
    for (Line& line : lines_) line.in_flight.close();
    for (Line& line : lines_) line.completion.join();
  }

  DeviceInfo info() const override {
    const PhysicalDevice& device = pool_->device->info();
    return {device.name,   device.driver,      std::string(pool_->tracer->name()),
            pool_->raster, device.pci_address, device.type == VK_PHYSICAL_DEVICE_TYPE_CPU};
  }

  void on_slot_freed(std::function<void()> freed) override { pool_->freed = std::move(freed); }

  Result<void> make_resident(SceneId id, const scenes::ScenePtr& scene) override {
    if (scenes_.contains(id)) return {};
    auto resident =
        ResidentScene::create(pool_->device, scene, pool_->tracer.get(), pool_->lanes.slots(), pool_->built);
    if (!resident) return resident.error();
    scenes_[id] = std::move(*resident);
    give_back_freed_memory();
    return {};
  }
  void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
             std::function<void()> wake) override {
    light_builds_.hold();  // until the scene can be looked at, if only by way of a hierarchy
    background_.run(
        [this, id, scene, pool = pool_, lane_is_there = pool_->lanes.has_motion(), resident] {
          const auto made = std::make_shared<Arrived>(arrive(*pool, scene, lane_is_there));
          return [this, id, made, resident] {
            resident(settle_in(id, *made));
            light_builds_.release();
          };
        },
        std::move(wake));
  }
  void evict(SceneId id) override {
    start_pending();  // what it parks is freed when all that was started before has passed
    scenes_.erase(id);
    light_builds_.stop(id);
  }

  SceneFootprint footprint(SceneId id) const override {
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return {};
    const TracedScene& traced = found->second->traced();
    return {found->second->memory_bytes(),     traced.memory_bytes(),          traced.build_seconds,
            traced.list_statistics.from_cache, traced.list_statistics.average, traced.list_statistics.longest};
  }

  void set_lights(SceneId id, std::vector<scenes::Light> lights, std::function<void(Result<void>)> changed,
                  std::function<void()> wake) override {
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return changed(not_resident(id));
    if (!found->second->needs_still_bvh(lights)) return changed(found->second->set_lights(std::move(lights)));
    background_.run(
        [this, id, scene = found->second->scene_ptr(), device = pool_->device, lights = std::move(lights),
         changed] {
          const auto bvh = build_still_bvh(device, *scene);
          return [this, id, scene, bvh, lights, changed] {
            ResidentScene* resident = resident_of(id, scene);
            if (!resident) return changed(not_resident(id));
            if (!bvh) return changed(bvh.error());
            resident->give_still_bvh(*bvh);
            changed(resident->set_lights(lights));
          };
        },
        std::move(wake));
  }

  void settle_lights(SceneId id, std::function<void(Result<void>)> settled, std::function<void()> wake) override {
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return settled(not_resident(id));
    if (!pool_->tracer->builds_for_lights()) return settled({});
    light_builds_.start(
        id, found->second->light_count(),
        [this, id, scene = found->second->scene_ptr(), pool = pool_, lights = found->second->lights(),
         settled](const BuildWatch& watch) {
          const auto built = build_for_lights(*pool->tracer, *scene, lights, watch);
          return [this, id, scene, built, settled] {
            ResidentScene* resident = resident_of(id, scene);
            if (!resident) return settled(not_resident(id));
            if (!built) return settled(built.error());
            resident->give_traced(*built);
            settled({});
          };
        },
        std::move(wake));
  }

  void finish_background() override {
    background_.finish();
    light_builds_.finish();
  }

  LightState light_state(SceneId id) const override {
    const auto found = scenes_.find(id);
    return found == scenes_.end() ? LightState{} : found->second->light_state();
  }

  BuildProgress build_progress(SceneId id) const override { return light_builds_.progress(id); }

  uint32_t free_slots() const override { return pool_->free_count(); }

  Result<void> make_room(const RenderJob& job) override {
    const auto found = scenes_.find(job.scene);
    if (found == scenes_.end()) return not_resident(job.scene);
    if (auto fits = check_size(*pool_->device, job.width, job.height); !fits) return fits;
    const ResidentScene& scene = *found->second;
    const TileGrid grid{job.width, job.height, scene.light_count()};
    const auto lane = pool_->lanes.lane_for(*scene.pose(job.time));
    if (!lane) return lane.error();
    std::vector<FrameSlot>& slots = (*lane)->slots;
    const bool held =
        std::any_of(slots.begin(), slots.end(), [&](const FrameSlot& slot) { return slot.holds(scene, grid); });
    if (held || free_slots() == 0) return {};
    const size_t free = pool_->take();
    const auto room = slots[free].reserve((*lane)->plan, scene, grid);
    pool_->give_back(free);
    return room;
  }

  Result<void> submit(const RenderJob& job, std::function<void(FrameDone)> on_done) override {
    const auto scene = scenes_.find(job.scene);
    if (scene == scenes_.end()) return not_resident(job.scene);
    if (auto fits = check_size(*pool_->device, job.width, job.height); !fits) return fits;
    if (free_slots() == 0) return Error{"all frame slots are taken"};
    const TileGrid grid{job.width, job.height, scene->second->light_count()};
    const uint32_t rows = std::min(job.tile_rows.value_or(grid.tiles_y()), grid.tiles_y());
    const PosedScenePtr posed = scene->second->pose(job.time);
    const auto lane = pool_->lanes.lane_for(*posed);
    if (!lane) return lane.error();
    const size_t slot = pool_->take();
    const auto band = record(**lane, slot, *scene->second, posed, {job.camera, grid, job.untraced}, rows);
    if (!band) {
      pool_->give_back(slot);
      return band.error();
    }
    const bool last = rows == grid.tiles_y();
    if (!last) begun_[job.id] = {slot, *lane, job.scene, grid, rows};
    pend(*band, {job.id, slot, *lane, band->timestamps, true, last, kNeverStarted, grid, std::move(on_done)});
    return {};
  }

  Result<void> resume(JobId id, uint32_t tile_rows, std::function<void(FrameDone)> on_done) override {
    const auto found = begun_.find(id);
    if (found == begun_.end()) return Error{"frame " + std::to_string(id.value) + " was not begun"};
    Begun& frame = found->second;
    if (frame.holed) return Error{"a band of frame " + std::to_string(id.value) + " was not started"};
    const auto scene = scenes_.find(frame.scene);
    if (scene == scenes_.end()) return not_resident(frame.scene);
    const uint32_t rows = std::min(tile_rows, frame.grid.tiles_y() - frame.next_row);
    const auto band = frame.lane->slots[frame.slot].record_more(frame.lane->plan, *scene->second, rows);
    if (!band) return band.error();
    frame.next_row += rows;
    const bool last = frame.next_row == frame.grid.tiles_y();
    pend(*band, {id, frame.slot, frame.lane, band->timestamps, false, last, kNeverStarted, frame.grid,
                 std::move(on_done)});
    if (last) begun_.erase(found);
    return {};
  }

  void abandon(JobId id) override {
    const auto found = begun_.find(id);
    if (found == begun_.end()) return;
    start_pending();  // what is recorded of it refers to its slot
    const size_t slot = found->second.slot;
    line_of(slot).in_flight.push({id, slot, nullptr, VK_NULL_HANDLE, false, true, 0, {}, nullptr});
    begun_.erase(found);
  }

  void begin_batch() override { batching_ = true; }
  void end_batch() override {
    batching_ = false;
    start_pending();
  }

 private:
  // A scene made beside the frames, and the lane for motion, if it is the first that needs it.
  struct Arrived {
    Result<std::unique_ptr<ResidentScene>> scene;
    std::unique_ptr<Lane> motion;
  };

  // Any thread.
  static Arrived arrive(const SlotPool& pool, const scenes::ScenePtr& scene, bool lane_is_there) {
    Arrived made{ResidentScene::create(pool.device, scene, pool.tracer.get(), pool.lanes.slots(), pool.built),
                 nullptr};
    if (!made.scene || lane_is_there || !((*made.scene)->unbuilt() || scenes::moves(*scene))) return made;
    if (auto lane = pool.lanes.make_motion()) made.motion = std::move(*lane);  // else the first frame says why
    return made;
  }

  Result<void> settle_in(SceneId id, Arrived& made) {
    if (!made.scene) return made.scene.error();
    if (made.motion) pool_->lanes.give_motion(std::move(made.motion));
    scenes_[id] = std::move(*made.scene);
    return {};
  }

  static Error not_resident(SceneId id) { return Error{"scene " + std::to_string(id.value) + " is not resident"}; }
  // Null: it was evicted, or is another scene by now.
  ResidentScene* resident_of(SceneId id, const scenes::ScenePtr& scene) const {
    const auto found = scenes_.find(id);
    return found != scenes_.end() && found->second->scene_ptr() == scene ? found->second.get() : nullptr;
  }

  Line& line_of(size_t slot) { return lines_[slot % lines_.size()]; }
  Queue& queue_of(size_t slot) const { return pool_->device->queue(slot % lines_.size()); }

  void start_pending() {
    for (Line& line : lines_) {
      if (line.pending.empty()) continue;
      const size_t slot = line.pending.front().slot;
      const auto first = queue_of(slot).submit(line.commands, &pool_->device->queue());
      for (size_t i = 0; i < line.pending.size(); ++i) {
        if (first) {
          line.pending[i].timeline = *first + i;
        } else {
          not_started(line.pending[i]);
        }
        line.in_flight.push(std::move(line.pending[i]));
      }
      line.pending.clear();
      line.commands.clear();
    }
  }

  void not_started(InFlight& band) {
    band.out_of_memory = !queue_of(band.slot).lost();
    if (const auto frame = begun_.find(band.id); frame != begun_.end()) frame->second.holed = true;
  }

  static Result<RecordedBand> record(Lane& lane, size_t number, const ResidentScene& scene,
                                     const PosedScenePtr& posed, const FrameView& view, uint32_t rows) {
    FrameSlot& slot = lane.slots[number];
    if (auto room = slot.reserve(lane.plan, scene, view.grid); !room) return room.error();
    return slot.record(lane.plan, scene, posed, view, rows);
  }

  void pend(const RecordedBand& band, InFlight frame) {
    Line& line = line_of(frame.slot);
    line.commands.push_back(band.commands);
    line.pending.push_back(std::move(frame));
    if (!batching_) start_pending();
  }

  void complete(Line& line) {
    std::vector<InFlight> batch;
    for (line.in_flight.take(batch); !batch.empty(); line.in_flight.take(batch))
      for (InFlight& frame : batch) {
        if (frame.on_done) {
          frame.on_done(finish(frame));
        } else {
          pool_->give_back(frame.slot);
        }
      }
  }

  FrameDone finish(const InFlight& frame) {
    const FramePlan& plan = frame.lane->plan;
    const FrameSlot& slot = frame.lane->slots[frame.slot];
    FrameDone done;
    done.id = frame.id;
    done.complete = frame.last;
    if (frame.first) slot_gpu_ns_[frame.slot] = 0;
    const auto lease = [&](const PackedMaskView& mask) {
      return FrameLease(mask, [pool = pool_, slot = frame.slot] { pool->release(slot); });
    };
    const auto passed = frame.timeline == kNeverStarted ? Result<void>(Error{"the device took no work"})
                                                        : queue_of(frame.slot).wait(frame.timeline);
    auto timing = passed ? slot.timing(plan, frame.timestamps) : Result<FrameTiming>(passed.error());
    done.completed_at = Clock::now();
    if (!timing) {
      if (frame.last) done.mask = lease({});
      done.out_of_memory = frame.out_of_memory;
      done.device_lost = !frame.out_of_memory;
      return done;
    }
    done.gpu_ns = timing->total_ns;
    done.frame_gpu_ns = slot_gpu_ns_[frame.slot] += done.gpu_ns;
    done.stages = std::move(timing->stages);
    for (const StageTime& stage : done.stages) {
      if (stage.pass == "readback") done.readback_ns = stage.gpu_ns;
      if (stage.pass == "trace" || stage.pass == "trace_moving") done.trace_ns += stage.gpu_ns;
    }
    if (frame.last) done.mask = lease(slot.packed(plan, frame.grid));
    return done;
  }

  std::shared_ptr<SlotPool> pool_;
  std::map<SceneId, std::unique_ptr<ResidentScene>> scenes_;  // the render loop's
  std::map<JobId, Begun> begun_;
  bool batching_ = false;
  std::vector<uint64_t> slot_gpu_ns_;  // of its frame's bands so far; the completion thread's of the slot's queue
  std::vector<Line> lines_;
  Background background_;  // these end first
  LightBuilds light_builds_;
};

}  // namespace

Result<std::unique_ptr<Renderer>> make_renderer(const RendererOptions& options) {
  if (options.frames_in_flight < 1) return Error{"frames_in_flight: at least 1"};
  auto device = Device::create({options.device, options.validation, options.queues});
  if (!device) return device.error();
  auto tracer = make_tracer(options.tracer, *device, options.tracer_options);
  if (!tracer) return tracer.error();
  const auto raster = choose_raster(*device, options.raster);
  if (!raster) return raster.error();
  auto lanes =
      Lanes::create(*device, with_raster(options.passes, *raster), tracer->get(), options.frames_in_flight);
  if (!lanes) return lanes.error();
  if (std::find(options.passes.begin(), options.passes.end(), "readback") == options.passes.end())
    return Error{"the pass list has no 'readback': no mask would reach the host"};
  auto pool = std::make_shared<SlotPool>(*device, std::move(*tracer), *raster, std::move(*lanes),
                                         options.wait_for_builds ? Built::everything : Built::what_is_quick);
  return std::unique_ptr<Renderer>(std::make_unique<VulkanRenderer>(std::move(pool)));
}

}  // namespace gnomon::gpu
