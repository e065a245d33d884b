// Declare -> compile -> execute: an ordered list of passes, wired by the names of what they read and write.
#pragma once

#include <string>
#include <vector>

#include "gpu/passes/pass.h"
#include "gpu/vulkan/texels.h"

namespace gnomon::gpu {

// What a frame shows, a posed scene from a camera, and the number of its frame slot.
struct FrameSubject {
  const ResidentScene& scene;
  const PosedScene& posed;
  const FrameView& view;
  uint32_t slot = 0;
};

// The memory of one frame slot for every resource of a plan, and the descriptor sets that refer to it.
struct FrameResources {
  struct Entry {
    Image image;
    Buffer buffer;
    TexelSet texels;
    const Buffer* given = nullptr;

    const Buffer& any_buffer() const { return given ? *given : buffer; }
  };
  Capacity capacity;
  Buffer uniforms;             // FrameUniforms, mapped
  Buffer resting_uniforms;     // FrameUniforms for Pass::for_resting_lights, mapped; only in plans for motion
  std::vector<Entry> entries;  // in the order of FramePlan's resources
  Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool;
  std::vector<VkDescriptorSet> sets;          // one for each pass
  std::vector<std::vector<BoundPort>> ports;  // for each pass
};

// Immutable once compiled; shared by all slots of a variant.
class FramePlan {
 public:
  // `tracer` may be null if no pass traces, and outlives the plan. Error: see make_passes; or a pass reads a resource
  // that no pass before it writes.
  static Result<FramePlan> compile(const DevicePtr& device, const std::vector<std::string>& passes,
                                   const Tracer* tracer, PlanKind kind = {});

  size_t pass_count() const { return passes_.size(); }
  std::string_view pass_name(size_t i) const { return passes_[i]->name(); }

  // Error: out of memory.
  Result<FrameResources> allocate(const Capacity& capacity) const;

  // Binds a buffer to a resource that is given (ResourceSpec), until the resources are allocated again. The buffer must
  // live until the device has passed all work that was executed with it.
  void give(FrameResources& resources, std::string_view name, const Buffer& buffer) const;

  // The buffer of that name; nullptr if the plan has none.
  const Buffer* buffer(const FrameResources& resources, std::string_view name) const;

  // Records the passes that have a share of the band and their barriers, and a timestamp before the first pass and
  // after each (queries 0...pass_count). The bands of a frame are executed in order, from the top row to the last. Work
  // submitted later to the queue sees what was written to given buffers.
  void execute(VkCommandBuffer commands, const FrameResources& resources, const FrameSubject& subject,
               const Band& band, VkQueryPool timestamps) const;

 private:
  struct Resource {
    std::string_view name;
    ResourceSpec spec;
    VkImageUsageFlags image_usage = 0;
    VkBufferUsageFlags buffer_usage = 0;
    bool as_texels = false;
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
  std::vector<std::vector<Barrier>> barriers_;  // before each pass; the last entry: after all passes, for the host
  std::vector<Resource> resources_;
  bool hands_on_ = false;  // whether a pass writes to a given buffer
};

}  // namespace gnomon::gpu
