#include "gpu/passes/passes.h"

namespace gnomon::gpu {

namespace {

using Make = std::function<Result<std::unique_ptr<Pass>>()>;

// A name in pass lists, and the passes that it stands for.
struct Recipe {
  std::string_view name;
  std::vector<Make> steps;
};

// They refer to the device, and to nothing else of the caller's.
std::vector<Recipe> recipes(const DevicePtr& device, const Tracer* tracer, PlanKind kind) {
  const auto trace = [&device, tracer, kind]() -> Result<std::unique_ptr<Pass>> {
    if (!tracer) return Error{"pass 'trace' needs a tracer"};
    return make_trace_pass(device, *tracer, kind.motion);
  };
  std::vector<Make> trace_steps{trace};
  if (kind.motion) trace_steps.push_back([&device] { return make_trace_moving_pass(device); });
  if (kind.soft) {
    trace_steps.push_back([] { return make_sample_points_pass(); });
    trace_steps.push_back([&device, tracer, kind] { return make_trace_soft_pass(device, *tracer, kind.motion); });
  }
  if (kind.occlusion)
    trace_steps.push_back([&device, kind] { return make_trace_occlusion_pass(device, kind.motion); });
  const auto read = [](std::string_view name, std::string_view source, std::string_view target) {
    return [=] { return make_readback_pass(name, source, target); };
  };
  using namespace resource;
  return {
      {"gbuffer",
       {[&device] { return make_cull_pass(device); }, [&device] { return make_occluders_pass(device); },
        [&device] { return make_depth_tiles_pass(device); }, [&device] { return make_cull_hidden_pass(device); },
        [&device] { return make_gbuffer_pass(device); }}},
      {"gbuffer_compute",
       {[&device] { return make_clear_visibility_pass(device); }, [&device] { return make_cull_runs_pass(device); },
        [&device] { return make_occluder_runs_pass(device); },
        [&device] { return make_large_occluders_pass(device); },
        [&device] { return make_occluder_blocks_pass(device); },
        [&device] { return make_visibility_tiles_pass(device); },
        [&device] { return make_cull_hidden_runs_pass(device); },
        [&device] { return make_triangle_runs_pass(device); },
        [&device] { return make_large_triangles_pass(device); }, [&device] { return make_blocks_pass(device); },
        [&device] { return make_resolve_pass(device); }}},
      {"gbuffer_all", {[&device] { return make_gbuffer_all_pass(device); }}},
      {"pose", {[] { return make_pose_pass(); }}},
      {"trace", trace_steps},
      {"pack", {[&device] { return make_pack_pass(device); }}},
      {"readback", {[&device] { return make_readback_packed_pass(device); }}},
      {"readback_masks", {read("readback_masks", kMasks, kHostMasks)}},
      {"readback_valid_bits", {read("readback_valid_bits", kValidBits, kHostValidBits)}},
      {"surface", {[&device] { return make_surface_pass(device); }}},
      {"readback_surface", {read("readback_surface", kSurface, kHostSurface)}},
      {"upload_masks", {[] { return make_upload_masks_pass(false); }}},
      {"keep_masks", {[] { return make_upload_masks_pass(true); }}},
      {"shade", {[&device] { return make_shade_pass(device); }}},
      {"readback_color", {read("readback_color", kColor, kHostColor)}},
      {"ids", {[&device] { return make_ids_pass(device, false); }}},
      {"keep_ids", {[&device] { return make_ids_pass(device, true); }}},
      {"readback_ids", {read("readback_ids", kIds, kHostIds)}},
      {"predict", {[&device] { return make_predict_pass(device); }}},
      {"accumulate", {[&device] { return make_accumulate_pass(device); }}},
      {"readback_sources", {read("readback_sources", kSources, kHostSources)}},
      {"shade_predicted", {[&device] { return make_shade_predicted_pass(device); }}},
      {"average", {[&device] { return make_average_pass(device); }}},
      {"readback_averaged", {read("readback_averaged", kAveraged, kHostAveraged)}},
      {"readback_draws",
       {read("readback_draws", kOccluderDraws, kHostOccluderDraws), read("readback_draws", kDraws, kHostDraws)}},
  };
}

}  // namespace

Result<Passes> make_passes(std::string_view name, const DevicePtr& device, const Tracer* tracer, PlanKind kind) {
  std::string names;
  for (const Recipe& recipe : recipes(device, tracer, kind)) {
    names += (names.empty() ? "" : ", ") + std::string(recipe.name);
    if (recipe.name != name) continue;
    Passes passes;
    for (const Make& make : recipe.steps) {
      auto pass = make();
      if (!pass) return pass.error();
      passes.push_back(std::move(*pass));
    }
    return passes;
  }
  return Error{"no pass is called '" + std::string(name) + "'; there are " + names};
}

Result<ComputeStep> make_compute_step(const DevicePtr& device, uint32_t sampled_images,
                                      std::span<const uint32_t> shader, uint32_t storage_images,
                                      uint32_t subgroup_size, std::span<const uint32_t> constants,
                                      std::span<const uint32_t> texel_sets) {
  auto layout = make_pass_layout(device, sampled_images, storage_images, texel_sets);
  if (!layout) return layout.error();
  auto pipeline = make_compute_pipeline(device, *layout, shader, subgroup_size, constants);
  if (!pipeline) return pipeline.error();
  // lavapipe gives each thread one contiguous part of a dispatch, and the rows of a picture differ in cost: several
  // small dispatches balance the threads.
  const bool cpu = device->info().type == VK_PHYSICAL_DEVICE_TYPE_CPU;
  return ComputeStep{std::move(*layout), std::move(*pipeline), cpu ? 8u : UINT32_MAX};
}

void bind(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push,
          std::span<const VkDescriptorSet> texels) {
  const VkPipelineLayout layout = step.layout.pipeline.get();
  vkCmdBindPipeline(frame.commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.pipeline.get());
  vkCmdBindDescriptorSets(frame.commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &frame.descriptors, 0,
                          nullptr);
  if (!texels.empty())
    vkCmdBindDescriptorSets(frame.commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 1,
                            static_cast<uint32_t>(texels.size()), texels.data(), 0, nullptr);
  push_constants(frame.commands, layout, push);
}

void dispatch_tiles(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push,
                    std::span<const VkDescriptorSet> texels) {
  bind(frame, step, push, texels);
  const uint32_t columns = (frame.grid.tiles_x() + step.tiles_at_once - 1) / step.tiles_at_once;
  for (uint32_t row = 0; row < frame.rows.count;) {
    const uint32_t count = std::min(step.rows_at_once, frame.rows.count - row);
    vkCmdDispatchBase(frame.commands, 0, frame.rows.first + row, 0, columns, count, 1);
    row += count;
  }
}

void push_constants(VkCommandBuffer commands, VkPipelineLayout layout, std::span<const std::byte> push) {
  constexpr VkShaderStageFlags stages =
      VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
  vkCmdPushConstants(commands, layout, stages, 0, static_cast<uint32_t>(push.size()), push.data());
}

}  // namespace gnomon::gpu
