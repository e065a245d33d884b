#include "gpu/frame/frame_plan.h"

#include <algorithm>
#include <array>

namespace gnomon::gpu {

// The last use of a resource, while the plan is wired.
struct LastUse {
  VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_NONE;
  VkAccessFlags2 access = VK_ACCESS_2_NONE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  bool written = false;
};

namespace {

constexpr VkPipelineStageFlags2 kDepthStages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

LastUse touch(Use use) {
  switch (use) {
    case Use::color_target:
      return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
              VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT,
              VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, true};
    case Use::depth_target:
      return {kDepthStages,
              VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
              VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, true};
    case Use::sampled:
      return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
              VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, false};
    case Use::storage_read:
    case Use::texel_read:
      return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_IMAGE_LAYOUT_GENERAL,
              false};
    case Use::storage_write:
      return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_IMAGE_LAYOUT_GENERAL,
              true};
    case Use::storage_update:
      return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
              VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_IMAGE_LAYOUT_GENERAL,
              true};
    case Use::indirect:
      return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
              VK_IMAGE_LAYOUT_UNDEFINED, false};
    case Use::indirect_read:
      return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
              VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
              VK_IMAGE_LAYOUT_UNDEFINED, false};
    case Use::vertex_read:
      return {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
              false};
    case Use::copy_source:
      return {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
              false};
    case Use::copy_target:
      return {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
              true};
    case Use::fill_target:
      return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
              true};
  }
  return {};
}

VkImageUsageFlags image_usage(Use use) {
  switch (use) {
    case Use::color_target: return VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    case Use::depth_target: return VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    case Use::sampled: return VK_IMAGE_USAGE_SAMPLED_BIT;
    case Use::copy_source: return VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    case Use::copy_target: return VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    default: return VK_IMAGE_USAGE_STORAGE_BIT;
  }
}

VkBufferUsageFlags buffer_usage(Use use) {
  if (use == Use::indirect || use == Use::indirect_read) return VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  if (use == Use::copy_source) return VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  if (use == Use::copy_target || use == Use::fill_target) return VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  return 0;
}

bool is_image(const ResourceSpec& spec) { return spec.format != VK_FORMAT_UNDEFINED; }

}  // namespace

Result<FramePlan> FramePlan::compile(const DevicePtr& device, const std::vector<std::string>& passes,
                                     const Tracer* tracer, PlanKind kind) {
  FramePlan plan;
  plan.device_ = device;
  plan.motion_ = kind.motion;
  std::vector<std::string> names = passes;
  if (kind.motion) names.insert(names.begin(), "pose");
  for (const std::string& name : names) {
    auto made = make_passes(name, device, tracer, kind);
    if (!made) return made.error();
    for (auto& pass : *made) {
      plan.ports_.push_back(pass->ports());
      plan.passes_.push_back(std::move(pass));
    }
  }
  if (auto wired = plan.wire(); !wired) return wired.error();
  return plan;
}

Result<void> FramePlan::wire() {
  std::vector<LastUse> last;
  barriers_.resize(passes_.size() + 1);
  for (size_t pass = 0; pass < passes_.size(); ++pass) {
    wiring_.emplace_back();
    for (const Port& port : ports_[pass]) {
      auto found = std::find_if(resources_.begin(), resources_.end(),
                                [&](const Resource& r) { return r.name == port.resource; });
      if (found == resources_.end()) {
        if (!writes(port.use) && port.spec.memory != MemoryUse::upload && !port.spec.given)
          return Error{"pass '" + std::string(passes_[pass]->name()) + "' reads '" + std::string(port.resource) +
                       "', which no pass before it writes"};
        resources_.push_back({port.resource, port.spec});
        last.emplace_back();
        found = resources_.end() - 1;
      }
      const size_t resource = static_cast<size_t>(found - resources_.begin());
      found->image_usage |= image_usage(port.use);
      found->buffer_usage |= buffer_usage(port.use);
      found->as_texels |= port.use == Use::texel_read;
      hands_on_ |= found->spec.given && writes(port.use);
      wiring_[pass].push_back(resource);
      add_barrier(pass, resource, port.use, last[resource]);
    }
  }
  for (size_t i = 0; i < resources_.size(); ++i) {
    if (is_image(resources_[i].spec) || resources_[i].spec.memory != MemoryUse::readback) continue;
    barriers_.back().push_back({i, last[i].stage, VK_PIPELINE_STAGE_2_HOST_BIT, last[i].access,
                                VK_ACCESS_2_HOST_READ_BIT, last[i].layout, last[i].layout});
  }
  return {};
}

// The first use of a buffer in a frame needs no barrier, because a slot is reused only when the device has passed its last
// frame; that of an image gives it its layout. Later a barrier stands before and behind what writes, and where the layout
// changes. Reads that follow each other without one are merged, so that what writes next waits for them all.
void FramePlan::add_barrier(size_t pass, size_t resource, Use use, LastUse& last) {
  const LastUse next = touch(use);
  const bool image = is_image(resources_[resource].spec);
  const bool first = last.stage == VK_PIPELINE_STAGE_2_NONE;
  const bool needed = image ? first || last.written || next.written || last.layout != next.layout
                            : !first && (last.written || next.written);
  if (needed)
    barriers_[pass].push_back(
        {resource, last.stage, next.stage, last.written ? last.access : 0, next.access, last.layout, next.layout});
  last = needed || first ? next : LastUse{last.stage | next.stage, last.access | next.access, next.layout, false};
}

Result<FrameResources> FramePlan::allocate(const Capacity& capacity) const {
  FrameResources out;
  out.capacity = capacity;
  for (Buffer* buffer : {&out.uniforms, motion_ ? &out.resting_uniforms : nullptr}) {
    if (!buffer) continue;
    auto uniforms =
        Buffer::create(device_, sizeof(FrameUniforms), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::upload);
    if (!uniforms) return uniforms.error();
    *buffer = std::move(*uniforms);
  }
  for (const Resource& resource : resources_) {
    FrameResources::Entry entry;
    if (resource.spec.given) {
      out.entries.push_back(std::move(entry));
      continue;
    }
    if (is_image(resource.spec)) {
      auto image =
          Image::create(device_, {capacity.width, capacity.height}, resource.spec.format, resource.image_usage);
      if (!image) return image.error();
      entry.image = std::move(*image);
    } else {
      auto buffer =
          Buffer::create(device_, resource.spec.bytes(capacity), resource.buffer_usage, resource.spec.memory);
      if (!buffer) return buffer.error();
      entry.buffer = std::move(*buffer);
      if (resource.as_texels && device_->features().loads_texels()) {
        auto texels = TexelSet::create(device_, {{{entry.buffer, VK_FORMAT_R32G32B32A32_UINT}}});
        if (!texels) return texels.error();
        entry.texels = std::move(*texels);
      }
    }
    out.entries.push_back(std::move(entry));
  }
  if (auto bound = bind(out); !bound) return bound.error();
  return out;
}

bool FramePlan::is_storage_image(size_t pass, size_t port) const {
  return ports_[pass][port].use == Use::storage_write && is_image(resources_[wiring_[pass][port]].spec);
}

Result<void> FramePlan::bind(FrameResources& out) const {
  if (auto made = make_descriptor_pool(out); !made) return made;
  for (size_t pass = 0; pass < passes_.size(); ++pass) {
    std::vector<BoundPort> bound;
    for (const size_t resource : wiring_[pass]) {
      const FrameResources::Entry& entry = out.entries[resource];
      const bool image = is_image(resources_[resource].spec);
      bound.push_back({image ? &entry.image : nullptr, image ? nullptr : &entry.buffer, entry.texels.handle()});
    }
    out.ports.push_back(std::move(bound));
    const auto set = make_descriptor_set(pass, out);
    if (!set) return set.error();
    out.sets.push_back(*set);
  }
  return {};
}

Result<void> FramePlan::make_descriptor_pool(FrameResources& out) const {
  const uint32_t passes = static_cast<uint32_t>(passes_.size());
  uint32_t sampled_images = 1, storage_images = 1;  // a pool size of 0 is not valid
  for (size_t pass = 0; pass < passes_.size(); ++pass)
    for (size_t port = 0; port < ports_[pass].size(); ++port) {
      sampled_images += ports_[pass][port].use == Use::sampled;
      storage_images += is_storage_image(pass, port);
    }
  const std::array sizes{VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, passes},
                         VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, sampled_images},
                         VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, storage_images}};
  VkDescriptorPoolCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  create.maxSets = passes;
  create.poolSizeCount = sizes.size();
  create.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorPool(device_->handle(), &create, nullptr, &pool); r != VK_SUCCESS)
    return vulkan_error(r, "creating a descriptor pool");
  out.pool = {device_, pool};
  return {};
}

// Returns VK_NULL_HANDLE if the pass binds nothing. The uniforms come first, then the sampled images, then the storage
// images.
Result<VkDescriptorSet> FramePlan::make_descriptor_set(size_t pass, const FrameResources& resources) const {
  const PassLayout* layout = passes_[pass]->layout();
  if (!layout) return VkDescriptorSet{VK_NULL_HANDLE};
  const VkDescriptorSetLayout set_layout = layout->set.get();
  VkDescriptorSetAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  allocate.descriptorPool = resources.pool.get();
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  if (const VkResult r = vkAllocateDescriptorSets(device_->handle(), &allocate, &set); r != VK_SUCCESS)
    return vulkan_error(r, "allocating a descriptor set");

  std::vector<VkDescriptorImageInfo> sampled, stored;
  for (size_t port = 0; port < ports_[pass].size(); ++port) {
    const FrameResources::Entry& entry = resources.entries[wiring_[pass][port]];
    if (ports_[pass][port].use == Use::sampled)
      sampled.push_back({VK_NULL_HANDLE, entry.image.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    if (is_storage_image(pass, port))
      stored.push_back({VK_NULL_HANDLE, entry.image.view(), VK_IMAGE_LAYOUT_GENERAL});
  }
  const Buffer& seen = passes_[pass]->for_resting_lights() ? resources.resting_uniforms : resources.uniforms;
  const VkDescriptorBufferInfo uniforms{seen.handle(), 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{};
  write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
  write.dstSet = set;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  write.pBufferInfo = &uniforms;
  std::vector<VkWriteDescriptorSet> all{write};
  const auto add = [&](VkDescriptorType type, const std::vector<VkDescriptorImageInfo>& images) {
    for (const VkDescriptorImageInfo& image : images) {
      write.dstBinding = static_cast<uint32_t>(all.size());
      write.descriptorType = type;
      write.pImageInfo = &image;
      all.push_back(write);
    }
  };
  add(VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, sampled);
  add(VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, stored);
  vkUpdateDescriptorSets(device_->handle(), static_cast<uint32_t>(all.size()), all.data(), 0, nullptr);
  return set;
}

void FramePlan::give(FrameResources& resources, std::string_view name, const Buffer& buffer) const {
  for (size_t i = 0; i < resources_.size(); ++i) {
    if (resources_[i].name != name || !resources_[i].spec.given) continue;
    resources.entries[i].given = &buffer;
    for (size_t pass = 0; pass < passes_.size(); ++pass)
      for (size_t port = 0; port < wiring_[pass].size(); ++port)
        if (wiring_[pass][port] == i) resources.ports[pass][port].buffer = &buffer;
  }
}

const Buffer* FramePlan::buffer(const FrameResources& resources, std::string_view name) const {
  for (size_t i = 0; i < resources_.size(); ++i)
    if (resources_[i].name == name && !is_image(resources_[i].spec)) return &resources.entries[i].buffer;
  return nullptr;
}

void FramePlan::wait_for(VkCommandBuffer commands, const FrameResources& resources, size_t pass,
                         bool for_images) const {
  std::vector<VkImageMemoryBarrier2> images;
  std::vector<VkBufferMemoryBarrier2> buffers;
  for (const Barrier& b : barriers_[pass]) {
    const FrameResources::Entry& entry = resources.entries[b.resource];
    if (is_image(resources_[b.resource].spec)) {
      if (!for_images) continue;
      images.push_back({VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                        nullptr,
                        b.from_stage,
                        b.from_access,
                        b.to_stage,
                        b.to_access,
                        b.from_layout,
                        b.to_layout,
                        VK_QUEUE_FAMILY_IGNORED,
                        VK_QUEUE_FAMILY_IGNORED,
                        entry.image.handle(),
                        {aspect_of(entry.image.format()), 0, 1, 0, 1}});
    } else {
      buffers.push_back({VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2, nullptr, b.from_stage, b.from_access,
                         b.to_stage, b.to_access, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED,
                         entry.any_buffer().handle(), 0, VK_WHOLE_SIZE});
    }
  }
  if (images.empty() && buffers.empty()) return;
  VkDependencyInfo dependency{};
  dependency.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
  dependency.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
  dependency.pImageMemoryBarriers = images.data();
  dependency.bufferMemoryBarrierCount = static_cast<uint32_t>(buffers.size());
  dependency.pBufferMemoryBarriers = buffers.data();
  vkCmdPipelineBarrier2(commands, &dependency);
}

void FramePlan::execute(VkCommandBuffer commands, const FrameResources& resources, const FrameSubject& subject,
                        const Band& band, VkQueryPool timestamps) const {
  const FrameView& view = subject.view;
  const auto stamp = [&](size_t query, VkPipelineStageFlags2 stage) {
    vkCmdWriteTimestamp2(commands, stage, timestamps, static_cast<uint32_t>(query));
  };
  vkCmdResetQueryPool(commands, timestamps, 0, static_cast<uint32_t>(passes_.size() + 1));
  stamp(0, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT);
  for (size_t pass = 0; pass < passes_.size(); ++pass) {
    const RunsIn bands = passes_[pass]->runs_in();
    const bool mine = band.has(bands);
    // Images change their layout once in a frame, in the band in which the pass runs, or first runs; buffers need their
    // barriers in every band.
    if (bands == RunsIn::last_band ? band.last : band.first) {
      wait_for(commands, resources, pass);
    } else if (mine) {
      wait_for(commands, resources, pass, false);
    }
    if (mine) {
      // A pass that runs once processes all rows of the frame.
      const TileRows whole{0, view.grid.tiles_y()};
      passes_[pass]->record({commands, resources.sets[pass], resources.ports[pass], subject.scene, subject.posed,
                             subject.slot, view.grid, view.untraced, view.samples,
                             bands == RunsIn::every_band ? band.rows : whole});
    }
    stamp(pass + 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
  }
  if (!band.last) return;
  wait_for(commands, resources, passes_.size());
  if (hands_on_) all_before_all_after(commands);
}

}  // namespace gnomon::gpu
