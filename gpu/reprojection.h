// What a view that was seen knows of another one: the pixel of it that shows the same surface. The dissertation's
// prediction (3.3) stands on it: bits are taken from there, and what the seen view does not show is lit by every
// light, so that no false shadow appears.
//
// A surface is taken for seen where one of the four pixels around its place in the seen view shows the same side of a
// surface within a pixel's width of it: hidden points are found by rasterising, so to within a pixel.
#pragma once

#include <memory>
#include <vector>

#include "gpu/blocking_frame.h"

namespace gnomon::gpu {

// Which triangle each pixel of a view shows, row by row: 1 + its number in the resident scene, 0: none.
struct RasterView {
  CameraView camera;
  uint32_t width = 0;
  uint32_t height = 0;
  scenes::SceneTime time{};
  std::vector<uint32_t> ids;
};

// Masks, and the view that they are of.
struct SeenMasks {
  RasterView raster;
  TileGrid grid;
  std::vector<uint64_t> words;

  TileMaskView mask() const { return {grid, words}; }
};

// Masks of another view of `width` x `height`, by its sources (see below); pixels without are lit by every light.
std::vector<uint64_t> masks_by_sources(const SeenMasks& seen, const std::vector<uint32_t>& sources, uint32_t width,
                                       uint32_t height);

// One thread. Calls block. Errors: size out of range, out of memory, device lost.
class Reprojection {
 public:
  // Shares the frame's device and scene.
  static Result<Reprojection> create(const BlockingFrame& beside);

  Result<RasterView> rasterise(const CameraView& camera, uint32_t width, uint32_t height, scenes::SceneTime time);

  // Error also: masks of another number of lights than the scene's.
  Result<SeenMasks> see(const CameraView& camera, const TileMaskView& masks, scenes::SceneTime time);

  // For each pixel of `view`: 0 where what it shows is not seen in `seen` (or is no surface), else 1 + the number of a
  // pixel of that. What moves is where it was at the time of `seen`.
  Result<std::vector<uint32_t>> sources(const RasterView& view, const RasterView& seen);

  // A picture, shaded with the masks that the sources give: four bytes a pixel, valid until the next call. `shading`:
  // ShadingUniforms.
  Result<std::span<const std::byte>> shade(const CameraView& camera, uint32_t width, uint32_t height,
                                           const SeenMasks& seen, std::span<const std::byte> shading);

 private:
  Result<TileGrid> reserve(BlockingFrame& frame, const RasterView& seen, uint32_t width, uint32_t height);

  std::unique_ptr<BlockingFrame> raster_, finder_, shader_;
};

}  // namespace gnomon::gpu
