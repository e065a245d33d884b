// What a view that was seen knows of another one: the pixel of it that shows the same surface. The dissertation's
// prediction (3.3) stands on it: bits are taken from there, and what the seen view does not show is lit by every
// light, so that no false shadow appears.
//
// A surface is taken for seen where one of the four pixels around its place in the seen view shows the same side of a
// surface within a pixel's width of it: hidden points are found by rasterising, so to within a pixel.
//
// What is kept of a view stays on the device: shaders read it at many places for every pixel.
#pragma once

#include <memory>
#include <span>
#include <vector>

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

// Masks, and the view that they are of.
struct SeenMasks {
  RasterView raster;
  TileGrid grid;
  std::shared_ptr<const Buffer> words;  // on the device, as common/tile_mask.h
};

// Masks of another view of `width` x `height`, by its sources (see below); pixels without are lit by every light.
std::vector<uint64_t> masks_by_sources(const TileMaskView& seen, std::span<const uint32_t> sources, uint32_t width,
                                       uint32_t height);

// One thread. Calls block, but rasterise and see, which only begin: later calls find what they leave. Errors: size out
// of range, out of memory, device lost.
class Reprojection {
 public:
  // Shares the frame's device and scene.
  static Result<Reprojection> create(const BlockingFrame& beside);

  Result<RasterView> rasterise(const CameraView& camera, uint32_t width, uint32_t height, scenes::SceneTime time);
  // The same where the triangles are known, row by row.
  Result<RasterView> raster_of(const CameraView& camera, uint32_t width, uint32_t height,
                               std::span<const uint32_t> ids);

  // Error also: masks of another number of lights than the scene's.
  Result<SeenMasks> see(const CameraView& camera, const TileMaskView& masks, scenes::SceneTime time);

  // For each pixel of `view`: 0 where what it shows is not seen in `seen` (or is no surface), else 1 + the number of a
  // pixel of that. What moves is where it was at the time of `seen`. Valid until the next call.
  Result<std::span<const uint32_t>> sources(const RasterView& view, const RasterView& seen);

  // A picture, shaded with the masks that the sources give: four bytes a pixel, valid until the next call. `shading`:
  // ShadingUniforms.
  Result<std::span<const std::byte>> shade(const CameraView& camera, uint32_t width, uint32_t height,
                                           const SeenMasks& seen, std::span<const std::byte> shading);

 private:
  Result<BlockingFrame*> when_needed(std::unique_ptr<BlockingFrame>& frame, const std::vector<std::string>& passes);
  Result<std::shared_ptr<Buffer>> buffer(uint64_t bytes);
  Result<RasterView> rasterise(BlockingFrame& frame, const TileGrid& grid, const CameraView& camera,
                               scenes::SceneTime time);

  DevicePtr device_;
  std::unique_ptr<BlockingFrame> seer_, shader_;
  std::unique_ptr<BlockingFrame> raster_, finder_;  // made when needed
  std::vector<std::shared_ptr<Buffer>> buffers_;    // lent, or free for what comes
};

}  // namespace gnomon::gpu
