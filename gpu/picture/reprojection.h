// Reprojection: for each pixel of a view, the pixel of another view that was seen before and shows the same surface.
// The dissertation's prediction (3.3) is based on it: visibility bits are taken from that pixel, and surfaces that the
// seen view does not show are lit by every light, so that no false shadow appears.
//
// A surface counts as seen if one of the four pixels around its place in the seen view shows the same side of a surface
// within a pixel's width of it. Hidden points are found by rasterising, hence to within a pixel.
//
// The data of a view stays on the device, because shaders read it at many places for every pixel.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/light_planes.h"
#include "gpu/passes/accumulation.h"
#include "gpu/picture/blocking_frame.h"

namespace gnomon::gpu {

// Which triangle each pixel of a view shows.
struct RasterView {
  CameraView camera;
  uint32_t width = 0;
  uint32_t height = 0;
  scenes::SceneTime time{};
  // On the device, row by row: 1 + its number in the resident scene, 0: none.
  std::shared_ptr<const Buffer> ids;
};

// Masks and the view that they belong to.
struct SeenMasks {
  RasterView raster;
  TileGrid grid;
  std::shared_ptr<const Buffer> words;        // on the device, as common/tile_mask.h
  LightPlanes planes = {};                    // of the grid's; without any: one for each light
  std::shared_ptr<const Buffer> shares = {};  // on the device, gpu/passes/accumulation.h; null: counts as they are
};

// How many samples of a pixel are shaded.
enum class Samples { one, four };

// The masks of a view of `width` x `height`, looked up in `seen` through the view's sources (Reprojection::sources);
// pixels without a source are lit by every light. Planes of area lights are looked up as
// they are.
std::vector<uint64_t> masks_by_sources(const TileMaskView& seen, std::span<const uint32_t> sources, uint32_t width,
                                       uint32_t height);

// One thread. Calls block, except rasterise and see, which only start the work that later calls use. Errors: the size
// is out of range, out of memory, device lost.
class Reprojection {
 public:
  // Shares the frame's device and scene.
  static Result<Reprojection> create(const BlockingFrame& beside);

  Result<RasterView> rasterise(const CameraView& camera, uint32_t width, uint32_t height, scenes::SceneTime time);
  // The view whose triangles are known. `ids`: row by row, as RasterView::ids.
  Result<RasterView> raster_of(const CameraView& camera, uint32_t width, uint32_t height,
                               std::span<const uint32_t> ids);

  // Rasterises the view of `masks` and uploads them. `planes`: of the masks; without any: one for each light. Error also:
  // the masks have others, or the planes are of another number of lights than the scene's.
  Result<SeenMasks> see(const CameraView& camera, const TileMaskView& masks, scenes::SceneTime time,
                        const LightPlanes& planes = {});

  // Pictures that are shaded with `newest` then show means of what it and up to three earlier masks count: of area lights
  // that no animation moves, and of ambient light. Each pixel takes the counts of those earlier ones that show its surface,
  // if that rests, but none that lies farther than one point beyond the counts of the pixels around it in `newest`. No
  // effect if `earlier` is empty or the masks count nothing. The lights' places and extents must be those of all masks.
  // Error also: `earlier` has more masks, or masks of another grid or of other planes.
  Result<void> accumulate(SeenMasks& newest, std::span<const SeenMasks> earlier);

  // The same for shares that are known, as accumulate() makes them (gpu/passes/accumulation.h). Error also: there are not as
  // many.
  Result<void> give_shares(SeenMasks& masks, std::span<const uint32_t> shares);

  // For each pixel of `view`: 0 if it shows no surface or one that `seen` does not show, else 1 + the number of the
  // pixel of `seen`, counted row by row. The scene time is that of `seen`. Valid until the next call.
  Result<std::span<const uint32_t>> sources(const RasterView& view, const RasterView& seen);

  // A picture that is shaded with the masks looked up through the sources: four bytes per pixel, valid until the next
  // call. `shading`: the bytes of ShadingUniforms. With four samples a pixel, which lie on a grid of 2x2, each sample
  // finds its own source, and the pixel is their mean in linear light. From the eye of the seen view itself, a sample
  // takes the bits of the pixel that it lies in if that pixel shows the sample's surface, else those of one of the three
  // other pixels around it that does; else, for want of better ones, those of the first of the four with any surface.
  Result<std::span<const std::byte>> shade(const CameraView& camera, uint32_t width, uint32_t height,
                                           const SeenMasks& seen, std::span<const std::byte> shading,
                                           Samples samples);

 private:
  Result<BlockingFrame*> when_needed(std::unique_ptr<BlockingFrame>& frame, const std::vector<std::string>& passes);
  Result<std::shared_ptr<Buffer>> buffer(uint64_t bytes);
  Result<RasterView> rasterise(BlockingFrame& frame, const TileGrid& grid, const CameraView& camera,
                               scenes::SceneTime time);

  DevicePtr device_;
  std::unique_ptr<BlockingFrame> seer_, shader_;
  std::unique_ptr<BlockingFrame> raster_, finder_, smoother_, accumulator_;  // made when needed
  std::vector<std::shared_ptr<Buffer>> buffers_;  // in use elsewhere, or free if use_count() is 1
};

}  // namespace gnomon::gpu
