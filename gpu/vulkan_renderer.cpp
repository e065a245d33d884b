#include "gpu/vulkan_renderer.h"

#include <algorithm>
#include <map>

#include "gpu/frame/queue_state.h"
#include "gpu/frame/resident_scenes.h"
#include "gpu/passes/mask_passes.h"
#include "gpu/raster_choice.h"

namespace gnomon::gpu {
namespace {

// A frame of which not all rows were submitted.
struct BandedFrame {
  size_t slot = 0;
  PlanVariant* variant = nullptr;
  SceneId scene;
  TileGrid grid;
  uint32_t next_row = 0;
  size_t queue = 0;          // of all its bands
  bool band_failed = false;  // one of its bands was never started
};

class VulkanRenderer : public Renderer {
 public:
  VulkanRenderer(std::shared_ptr<SlotPool> pool, const RendererOptions& options, const std::string& raster)
      : pool_(std::move(pool)),
        raster_(raster),
        light_buffer_room_(light_buffer_room(pool_->device()->info(), options.tracer_options)),
        scenes_(pool_, options.wait_for_builds ? Built::everything : Built::what_is_quick) {
    for (size_t i = 0; i < pool_->device()->queue_count(); ++i)
      queues_.push_back(std::make_unique<QueueState>(pool_, i));
  }
  ~VulkanRenderer() override {
    start_pending();
    queues_.clear();
  }

  DeviceInfo info() const override {
    const PhysicalDevice& device = pool_->device()->info();
    return {device.name,       device.driver,      std::string(pool_->tracer().name()),
            raster_,           device.pci_address, device.type == VK_PHYSICAL_DEVICE_TYPE_CPU,
            light_buffer_room_};
  }
  uint32_t overlapping() const override { return static_cast<uint32_t>(queues_.size()); }
  void on_slot_freed(std::function<void()> freed) override { pool_->on_freed(std::move(freed)); }

  Result<void> make_resident(SceneId id, const scenes::ScenePtr& scene) override {
    return scenes_.make_resident(id, scene);
  }
  void set_owner(SceneId id, SceneOwner owner) override { scenes_.set_owner(id, owner); }
  void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
             std::function<void()> wake) override {
    scenes_.bring(id, scene, std::move(resident), std::move(wake));
  }
  void evict(SceneId id) override {
    start_pending();  // the scene's objects are freed when the device has passed all submits started before
    scenes_.evict(id);
  }
  void set_lights(SceneId id, std::vector<scenes::Light> lights, std::function<void(Result<void>)> changed,
                  std::function<void()> /*wake*/) override {
    changed(scenes_.set_lights(id, std::move(lights)));
  }
  void rebuild_lights(SceneId id, std::function<void(Result<void>)> settled, std::function<void()> wake) override {
    scenes_.rebuild_lights(id, std::move(settled), std::move(wake));
  }
  void finish_background() override { scenes_.finish_background(); }

  SceneFootprint footprint(SceneId id) const override {
    const ResidentScene* scene = scenes_.find(id);
    if (!scene) return {};
    const TracedScene& traced = scene->traced();
    return {scene->memory_bytes(),          traced.memory_bytes(),
            traced.build_seconds,           traced.list_statistics.from_cache,
            traced.list_statistics.average, traced.list_statistics.longest,
            traced.list_statistics.not_kept};
  }
  LightState light_state(SceneId id) const override {
    const ResidentScene* scene = scenes_.find(id);
    return scene ? scene->light_state() : LightState{};
  }
  BuildProgress build_progress(SceneId id) const override { return scenes_.build_progress(id); }

  uint32_t free_slots() const override { return pool_->free_count(); }

  Result<void> make_room(const RenderJob& job) override {
    const ResidentScene* scene = scenes_.find(job.scene);
    if (!scene) return not_resident(job.scene);
    if (auto fits = check_size(*pool_->device(), job.width, job.height); !fits) return fits;
    const SampleCounts samples = scene->area_lights().samples(job.samples);
    const TileGrid grid{job.width, job.height, scene->area_lights().plane_count(samples)};
    const auto variant = pool_->variants().variant_for(*scene->pose(job.time), samples);
    if (!variant) return variant.error();
    std::vector<FrameSlot>& slots = (*variant)->slots;
    const bool held =
        std::any_of(slots.begin(), slots.end(), [&](const FrameSlot& slot) { return slot.holds(*scene, grid); });
    if (held || free_slots() == 0) return {};
    const size_t free = pool_->take();
    const auto room = slots[free].reserve((*variant)->plan, *scene, grid);
    pool_->give_back(free);
    return room;
  }

  Result<void> submit(const RenderJob& job, std::function<void(FrameDone)> on_done) override {
    const ResidentScene* scene = scenes_.find(job.scene);
    if (!scene) return not_resident(job.scene);
    if (auto fits = check_size(*pool_->device(), job.width, job.height); !fits) return fits;
    if (free_slots() == 0) return Error{"all frame slots are taken"};
    const SampleCounts samples = scene->area_lights().samples(job.samples);
    if (samples.per_light > 1) scenes_.build_areas(job.scene);
    const TileGrid grid{job.width, job.height, scene->area_lights().plane_count(samples)};
    const uint32_t rows = std::min(job.tile_rows.value_or(grid.tiles_y()), grid.tiles_y());
    const PosedScenePtr posed = scene->pose(job.time);
    const auto variant = pool_->variants().variant_for(*posed, samples);
    if (!variant) return variant.error();
    const size_t slot = pool_->take();
    const auto band = record(**variant, slot, *scene, posed, {job.camera, grid, job.untraced, samples}, rows);
    if (!band) {
      pool_->give_back(slot);
      return band.error();
    }
    const bool last = rows == grid.tiles_y();
    const size_t queue = quietest_queue();
    if (!last) partial_frames_[job.id] = {slot, *variant, job.scene, grid, rows, queue};
    pend(queue, {job.id, slot, *variant, *band, true, last, grid, std::move(on_done)});
    return {};
  }

  Result<void> resume(JobId id, uint32_t tile_rows, std::function<void(FrameDone)> on_done) override {
    const auto found = partial_frames_.find(id);
    if (found == partial_frames_.end()) return Error{"frame " + std::to_string(id.value) + " was not begun"};
    BandedFrame& frame = found->second;
    if (frame.band_failed) return Error{"a band of frame " + std::to_string(id.value) + " was not started"};
    const ResidentScene* scene = scenes_.find(frame.scene);
    if (!scene) return not_resident(frame.scene);
    const uint32_t rows = std::min(tile_rows, frame.grid.tiles_y() - frame.next_row);
    const auto band = frame.variant->slots[frame.slot].record_more(frame.variant->plan, *scene, rows);
    if (!band) return band.error();
    frame.next_row += rows;
    const bool last = frame.next_row == frame.grid.tiles_y();
    pend(frame.queue, {id, frame.slot, frame.variant, *band, false, last, frame.grid, std::move(on_done)});
    if (last) partial_frames_.erase(found);
    return {};
  }

  void abandon(JobId id) override {
    const auto found = partial_frames_.find(id);
    if (found == partial_frames_.end()) return;
    start_pending();  // the frame's pending submits refer to its slot
    queues_[found->second.queue]->free_later(found->second.slot);
    partial_frames_.erase(found);
  }

  void begin_batch() override { batching_ = true; }
  void end_batch() override {
    batching_ = false;
    start_pending();
  }

 private:
  // The queue with the fewest submits; of several the one after the last that was chosen.
  size_t quietest_queue() {
    size_t best = (last_queue_ + 1) % queues_.size();
    for (size_t i = 2; i <= queues_.size(); ++i) {
      const size_t other = (last_queue_ + i) % queues_.size();
      if (queues_[other]->in_flight() < queues_[best]->in_flight()) best = other;
    }
    return last_queue_ = best;
  }

  void pend(size_t queue, InFlight submit) {
    queues_[queue]->pend(std::move(submit));
    if (!batching_) start_pending();
  }
  void start_pending() {
    for (const auto& queue : queues_) {
      for (const JobId refused : queue->start()) {
        const auto frame = partial_frames_.find(refused);
        if (frame != partial_frames_.end()) frame->second.band_failed = true;
      }
    }
  }

  static Result<RecordedBand> record(PlanVariant& variant, size_t number, const ResidentScene& scene,
                                     const PosedScenePtr& posed, const FrameView& view, uint32_t rows) {
    FrameSlot& slot = variant.slots[number];
    if (auto room = slot.reserve(variant.plan, scene, view.grid); !room) return room.error();
    return slot.record(variant.plan, scene, posed, view, rows);
  }

  const std::shared_ptr<SlotPool> pool_;
  const std::string raster_;
  const uint64_t light_buffer_room_;
  ResidentScenes scenes_;
  std::map<JobId, BandedFrame> partial_frames_;
  bool batching_ = false;
  std::vector<std::unique_ptr<QueueState>> queues_;
  size_t last_queue_ = 0;
};

}  // namespace

namespace {

// Whether one of the passes uses the graphics pipeline.
bool draws(const std::vector<std::string>& passes) {
  return std::any_of(passes.begin(), passes.end(),
                     [](const std::string& pass) { return pass == "gbuffer" || pass == "gbuffer_all"; });
}

Result<void> check_device(const RendererOptions& options) {
  const auto instance = Instance::create(options.validation);
  if (!instance) return instance.error();
  const auto device = choose_device(**instance, options.device);
  return device ? Result<void>() : device.error();
}

}  // namespace

std::vector<Error> check_options(const RendererOptions& options) {
  std::vector<Error> errors;
  const auto check = [&](const char* option, const Result<void>& checked) {
    if (!checked) errors.push_back(Error{std::string(option) + ": " + checked.error().message});
  };
  check("device", check_device(options));
  check("tracer", check_tracer_name(options.tracer));
  check("passes", check_mask_passes(options.passes));
  return errors;
}

Result<std::unique_ptr<Renderer>> make_renderer(const RendererOptions& options) {
  if (options.frames_in_flight < 1) return Error{"frames_in_flight: at least 1"};
  DeviceOptions opened{options.device, options.validation, options.queues};
  opened.texel_loads = options.texel_loads;
  auto device = Device::create(opened);
  if (!device) return device.error();
  const auto raster = choose_raster(*device, options.raster);
  if (!raster) return raster.error();
  if (!draws(with_raster(options.passes, *raster))) {
    opened.compute_only = true;
    device = Device::create(opened, *device);
    if (!device) return device.error();
  }
  auto tracer = make_tracer(options.tracer, *device, options.tracer_options);
  if (!tracer) return tracer.error();
  auto variants =
      PlanVariants::create(*device, with_raster(options.passes, *raster), tracer->get(), options.frames_in_flight);
  if (!variants) return variants.error();
  if (std::find(options.passes.begin(), options.passes.end(), "readback") == options.passes.end())
    return Error{"the pass list has no 'readback': no mask would reach the host"};
  auto pool = std::make_shared<SlotPool>(*device, std::move(*tracer), std::move(*variants));
  return std::unique_ptr<Renderer>(std::make_unique<VulkanRenderer>(std::move(pool), options, *raster));
}

}  // namespace gnomon::gpu
