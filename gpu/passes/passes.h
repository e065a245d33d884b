// The passes, the resources that they share, and what compute passes have in common.
//
//   pose      -> moving_bvh; the first pass in plans for scenes in motion: copies moving geometry from the host
//             resource moving_host to the slot's part of the scene's buffers, and the hierarchy over it
//   gbuffer   -> triangle_id (uint32: 0 none, else 1 + the triangle's number in the resident scene), depth
//             in these steps:
//     cull         -> occluder_draws, drawn_occluders: the large triangles that may show
//     occluders    occluder_draws, drawn_occluders -> triangle_id, depth
//     depth_tiles  depth -> depth_tiles (float: the farthest depth of each tile)
//     cull_hidden  depth_tiles -> draws, drawn: the other triangles that may show
//     gbuffer      draws, drawn -> triangle_id, depth
//   gbuffer_all  the same result as gbuffer, bit for bit, by drawing everything: for comparison
//   gbuffer_compute  the same result as gbuffer except at edges, without the graphics pipeline, in these steps
//             (shaders/raster.glsl):
//     clear        -> visibility (64 bits a pixel: depth, triangle), and all lists, empty
//     cull         -> occluder_runs: clusters of the large triangles that may show
//     occluders    occluder_runs -> visibility, occluder_large (what is too large for one invocation)
//     occluders_large  occluder_large -> occluder_blocks (of the triangles that are divided), visibility (the others)
//     occluder_blocks  occluder_blocks -> visibility
//     depth_tiles  visibility -> depth_tiles
//     cull_hidden  depth_tiles -> runs: clusters of all others that may show
//     triangles    runs -> visibility, large; also the moving triangles
//     large        large -> blocks, visibility
//     blocks       blocks -> visibility
//     resolve      visibility -> triangle_id
//   trace     triangle_id -> masks (tile words, see common/tile_mask.h), valid_bits (words of the same layout: 1 where
//             the pair of pixel and light was traced, see exact.glsl; elsewhere the bit of the mask is 0, whatever
//             hides the light)
//             in plans for scenes in motion in two steps:
//     trace         as above, for resting lights and resting geometry
//     trace_moving  moving_bvh -> masks, valid_bits: moving lights, and what moving geometry hides from all lights
//             in plans for soft frames two more:
//     sample_points  from the host soft_host -> soft_lights: the points of the area lights that are traced
//     trace_soft     soft_lights, moving_bvh -> masks, valid_bits: all planes of the area lights, which the steps before
//                    leave out
//             in plans for frames with ambient occlusion, last:
//     trace_occlusion  from the host occlusion_points, moving_bvh -> masks, valid_bits: the planes behind those of the
//                    lights
//   pack      masks, valid_bits -> classes, mixed_places, as common/packed_mask.h explains: the place of each group's
//             mixed words within its workgroup, then the number of each workgroup
//   readback  masks, valid_bits, classes, mixed_places -> host_classes, host_mixed, host_mixed_count
//   surface   triangle_id -> surface (SurfaceSample for each pixel): what `trace` starts from, for tests
//   upload_masks  from the host uploaded_masks -> given_masks
//   keep_masks    as upload_masks, into a given buffer
//   shade     triangle_id, given_masks, and from the host shading -> color (RGBA8): the client's picture
//   ids       triangle_id -> ids (a copy in a buffer)
//   keep_ids  as ids, into a given buffer: what a client keeps of a view
//   predict   ids (of this frame or given), seen_ids of another view (given), and from the host seen_view -> sources
//             (uint32 for each pixel: 0, or 1 + the pixel of that view that shows the same surface)
//   accumulate  ids and given_masks of the newest masks' view, earlier_ids and earlier_masks of up to three others (all
//             given), and from the host accumulation and earlier_views -> shares (given): what the masks count, as means
//             over those of them that show the same surface (gpu/passes/accumulation.h)
//   shade_predicted  as shade, with given_masks (given) of the seen view, looked up through sources; all lights shine
//             where the source is 0; instead of counts the shares (given), where the host says so
//   average   color, shaded at 2x2 samples a pixel -> averaged (RGBA8, half as wide and half as high)
//   readback_masks  masks -> host_masks  readback_valid_bits    valid_bits -> host_valid_bits
//   readback_color  color -> host_color  readback_surface  surface -> host_surface
//   readback_averaged  averaged -> host_averaged
//   readback_ids  ids -> host_ids  readback_sources  sources -> host_sources
//   readback_draws  occluder_draws, draws -> host_occluder_draws, host_draws (VkDrawIndirectCommand for each chunk)
#pragma once

#include <array>

#include "gpu/passes/pass.h"

namespace gnomon::gpu {

namespace resource {
inline constexpr std::string_view kMovingHost = "moving_host";
inline constexpr std::string_view kMovingBvh = "moving_bvh";
inline constexpr std::string_view kTriangleId = "triangle_id";
inline constexpr std::string_view kDepth = "depth";
inline constexpr std::string_view kOccluderDraws = "occluder_draws";
inline constexpr std::string_view kDrawnOccluders = "drawn_occluders";
inline constexpr std::string_view kDepthTiles = "depth_tiles";
inline constexpr std::string_view kDraws = "draws";
inline constexpr std::string_view kDrawn = "drawn";
inline constexpr std::string_view kVisibility = "visibility";
inline constexpr std::string_view kOccluderRuns = "occluder_runs";
inline constexpr std::string_view kOccluderLarge = "occluder_large";
inline constexpr std::string_view kOccluderBlocks = "occluder_blocks";
inline constexpr std::string_view kRuns = "runs";
inline constexpr std::string_view kLarge = "large";
inline constexpr std::string_view kBlocks = "blocks";
inline constexpr std::string_view kHostOccluderDraws = "host_occluder_draws";
inline constexpr std::string_view kHostDraws = "host_draws";
inline constexpr std::string_view kMasks = "masks";
inline constexpr std::string_view kHostMasks = "host_masks";
inline constexpr std::string_view kValidBits = "valid_bits";
inline constexpr std::string_view kHostValidBits = "host_valid_bits";
inline constexpr std::string_view kSoftHost = "soft_host";
inline constexpr std::string_view kSoftLights = "soft_lights";
inline constexpr std::string_view kOcclusionPoints = "occlusion_points";
inline constexpr std::string_view kClasses = "classes";
inline constexpr std::string_view kMixedPlaces = "mixed_places";
inline constexpr std::string_view kHostClasses = "host_classes";
inline constexpr std::string_view kHostMixed = "host_mixed";
inline constexpr std::string_view kHostMixedCount = "host_mixed_count";
inline constexpr std::string_view kSurface = "surface";
inline constexpr std::string_view kHostSurface = "host_surface";
inline constexpr std::string_view kUploadedMasks = "uploaded_masks";
inline constexpr std::string_view kGivenMasks = "given_masks";
inline constexpr std::string_view kShading = "shading";
inline constexpr std::string_view kColor = "color";
inline constexpr std::string_view kHostColor = "host_color";
inline constexpr std::string_view kAveraged = "averaged";
inline constexpr std::string_view kHostAveraged = "host_averaged";
inline constexpr std::string_view kIds = "ids";
inline constexpr std::string_view kHostIds = "host_ids";
inline constexpr std::string_view kSeenView = "seen_view";
inline constexpr std::string_view kSeenIds = "seen_ids";
inline constexpr std::string_view kSources = "sources";
inline constexpr std::string_view kHostSources = "host_sources";
inline constexpr std::string_view kAccumulation = "accumulation";
inline constexpr std::string_view kEarlierViews = "earlier_views";
inline constexpr std::array<std::string_view, 3> kEarlierIds{"earlier_ids_1", "earlier_ids_2", "earlier_ids_3"};
inline constexpr std::array<std::string_view, 3> kEarlierMasks{"earlier_masks_1", "earlier_masks_2",
                                                               "earlier_masks_3"};
inline constexpr std::string_view kShares = "shares";
}  // namespace resource

// One pixel's surface as the tracers see it. triangle: as in triangle_id.
struct SurfaceSample {
  glm::vec3 position{0.0f};
  uint32_t triangle = 0;
  glm::vec3 normal{0.0f};
  uint32_t reserved = 0;
};
static_assert(sizeof(SurfaceSample) == 32);

Result<std::unique_ptr<Pass>> make_pose_pass();
// Writes the moving geometry that the pass `pose` copies. `into`: the host memory of moving_host.
void write_moving(std::span<std::byte> into, const ResidentScene& scene, const PosedScene& posed, uint32_t slot);

Result<std::unique_ptr<Pass>> make_cull_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_occluders_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_depth_tiles_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_cull_hidden_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_gbuffer_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_gbuffer_all_pass(const DevicePtr& device);
// Error: the device lacks 64-bit atomics.
Result<std::unique_ptr<Pass>> make_clear_visibility_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_cull_runs_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_cull_hidden_runs_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_occluder_runs_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_large_occluders_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_occluder_blocks_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_visibility_tiles_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_triangle_runs_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_large_triangles_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_blocks_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_resolve_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_trace_pass(const DevicePtr& device, const Tracer& tracer, bool motion);
Result<std::unique_ptr<Pass>> make_trace_moving_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_sample_points_pass();
Result<std::unique_ptr<Pass>> make_trace_soft_pass(const DevicePtr& device, const Tracer& tracer, bool motion);
// Writes what the pass `sample_points` copies. `into`: the host memory of soft_host.
void write_soft(std::span<std::byte> into, const ResidentScene& scene, const PosedScene& posed,
                const FrameView& view);
Result<std::unique_ptr<Pass>> make_trace_occlusion_pass(const DevicePtr& device, bool motion);
// Writes what the pass `trace_occlusion` reads. `into`: the host memory of occlusion_points.
void write_occlusion(std::span<std::byte> into, const scenes::Scene& scene);
Result<std::unique_ptr<Pass>> make_pack_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_readback_packed_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_surface_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_shade_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_ids_pass(const DevicePtr& device, bool kept);
Result<std::unique_ptr<Pass>> make_predict_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_accumulate_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_shade_predicted_pass(const DevicePtr& device);
Result<std::unique_ptr<Pass>> make_average_pass(const DevicePtr& device);
// Of the averaged picture of a frame of that size.
inline uint64_t averaged_bytes(uint32_t width, uint32_t height) {
  return uint64_t{width / 2} * (height / 2) * sizeof(uint32_t);
}

// Copies the part of a buffer that this frame has written into cached host memory.
Result<std::unique_ptr<Pass>> make_readback_pass(std::string_view name, std::string_view source,
                                                 std::string_view target);

// Copies tile words that the host has written to device memory. `kept`: into a given buffer.
Result<std::unique_ptr<Pass>> make_upload_masks_pass(bool kept);

struct ComputeStep {
  PassLayout layout;
  Pipeline pipeline;
  uint32_t rows_at_once = 0;   // tile rows of one dispatch
  uint32_t tiles_at_once = 1;  // tiles of one workgroup, side by side
};
// `subgroup_size`, `constants`: as of make_compute_pipeline. `texel_sets`: as of make_pass_layout.
Result<ComputeStep> make_compute_step(const DevicePtr& device, uint32_t sampled_images,
                                      std::span<const uint32_t> shader, uint32_t storage_images = 0,
                                      uint32_t subgroup_size = 0, std::span<const uint32_t> constants = {},
                                      std::span<const uint32_t> texel_sets = {});

// Makes the pass `Made`, whose constructor takes the step first. Error: that of the step.
template <class Made, class... More>
Result<std::unique_ptr<Pass>> pass_of(Result<ComputeStep> step, More&&... more) {
  if (!step) return step.error();
  return std::unique_ptr<Pass>(std::make_unique<Made>(std::move(*step), std::forward<More>(more)...));
}

// Binds the step, the frame's descriptors and push constants, and the sets of texels that the step was made for.
void bind(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push,
          std::span<const VkDescriptorSet> texels = {});
// As bind, then dispatches one workgroup for each 8x8 tile, or for each step.tiles_at_once of a row, of frame.rows: the
// band's rows if the pass runs in every band, else all rows.
void dispatch_tiles(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push,
                    std::span<const VkDescriptorSet> texels = {});
void push_constants(VkCommandBuffer commands, VkPipelineLayout layout, std::span<const std::byte> push);

}  // namespace gnomon::gpu
