// Declare -> compile -> execute: an ordered list of passes, wired by the names of what they read and write.
#pragma once

#include <string>
#include <vector>

#include "gpu/passes/pass.h"

namespace gnomon::gpu {

// What a frame shows: the scene as it is posed, seen so, in one of the frames in flight.
struct FrameSubject {
  const ResidentScene& scene;
  const PosedScene& posed;
  const FrameView& view;
  uint32_t slot = 0;
};

// Memory of one frame slot for every resource of a plan, and the descriptor sets that point to it.
struct FrameResources {
  struct Entry {
    Image image;
    Buffer buffer;
    const Buffer* given = nullptr;

    const Buffer& any_buffer() const { return given ? *given : buffer; }
  };
  Capacity capacity;
  Buffer uniforms;             // FrameUniforms, mapped
  Buffer resting_uniforms;     // the same for Pass::for_resting_lights; in plans for scenes in motion
  std::vector<Entry> entries;  // as FramePlan's resources
  Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool;
  std::vector<VkDescriptorSet> sets;          // one for each pass
  std::vector<std::vector<BoundPort>> ports;  // for each pass
};

class FramePlan {
 public:
  // `tracer` may be null where no pass traces. `motion`: for scenes in which something moves. Error: see make_passes,
  // or a pass reads what none before it writes.
  static Result<FramePlan> compile(const DevicePtr& device, const std::vector<std::string>& passes,
                                   const Tracer* tracer, bool motion = false);

  size_t pass_count() const { return passes_.size(); }
  std::string_view pass_name(size_t i) const { return passes_[i]->name(); }

  // Error: out of memory.
  Result<FrameResources> allocate(const Capacity& capacity) const;

  // What the passes see as a resource that is given (ResourceSpec), until the resources are allocated anew. It lives
  // until the device has passed what is executed with it.
  void give(FrameResources& resources, std::string_view name, const Buffer& buffer) const;

  // The buffer of that name; null where the plan has none.
  const Buffer* buffer(const FrameResources& resources, std::string_view name) const;

  // Records the passes that have a share of the band and their barriers, and a timestamp before the first and
  // after each (queries 0...pass_count). Bands follow each other from the top to the last row. What comes later on the
  // queue sees what was written to given buffers.
  void execute(VkCommandBuffer commands, const FrameResources& resources, const FrameSubject& subject,
               const Band& band, VkQueryPool timestamps) const;

 private:
  struct Resource {
    std::string_view name;
    ResourceSpec spec;
    VkImageUsageFlags image_usage = 0;
    VkBufferUsageFlags buffer_usage = 0;
  };
  struct Barrier {
    size_t resource;
    VkPipelineStageFlags2 from_stage, to_stage;
    VkAccessFlags2 from_access, to_access;
    VkImageLayout from_layout, to_layout;
  };

  Result<void> wire();
  void add_barrier(size_t pass, size_t resource, Use use, struct LastUse& last);
  void wait_for(VkCommandBuffer commands, const FrameResources& resources, size_t pass,
                bool for_images = true) const;
  bool is_storage_image(size_t pass, size_t port) const;
  Result<void> bind(FrameResources& resources) const;
  Result<void> make_descriptor_pool(FrameResources& resources) const;
  Result<VkDescriptorSet> make_descriptor_set(size_t pass, const FrameResources& resources) const;

  DevicePtr device_;
  bool motion_ = false;
  std::vector<std::unique_ptr<Pass>> passes_;
  std::vector<std::vector<Port>> ports_;        // for each pass
  std::vector<std::vector<size_t>> wiring_;     // for each pass and port: the resource
  std::vector<std::vector<Barrier>> barriers_;  // before each pass; the last entry: after all, for the host
  std::vector<Resource> resources_;
  bool hands_on_ = false;  // writes to a given buffer
};

}  // namespace gnomon::gpu
