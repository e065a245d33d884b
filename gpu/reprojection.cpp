#include "gpu/reprojection.h"

#include <cstring>

#include "gpu/passes/passes.h"
#include "gpu/seen_view.h"

namespace gnomon::gpu {
namespace {

void copy_into(std::span<std::byte> target, std::span<const std::byte> source) {
  if (!source.empty()) std::memcpy(target.data(), source.data(), source.size());
}

std::vector<uint32_t> copied(std::span<const std::byte> source, size_t count) {
  std::vector<uint32_t> values(count);
  std::memcpy(values.data(), source.data(), count * sizeof(uint32_t));
  return values;
}

}  // namespace

std::vector<uint64_t> masks_by_sources(const SeenMasks& seen, const std::vector<uint32_t>& sources, uint32_t width,
                                       uint32_t height) {
  const TileGrid grid{width, height, seen.grid.lights};
  const TileMaskView mask = seen.mask();
  std::vector<uint64_t> words(grid.word_count(), ~uint64_t{0});
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t source = sources[size_t{y} * width + x];
      if (source == 0) continue;
      const uint32_t seen_x = (source - 1) % seen.grid.width, seen_y = (source - 1) / seen.grid.width;
      const size_t tile = size_t{y / kTileSize} * grid.tiles_x() + x / kTileSize;
      const uint64_t bit = uint64_t{1} << (y % kTileSize * kTileSize + x % kTileSize);
      for (uint32_t light = 0; light < grid.lights; ++light)
        if (!mask.lit(seen_x, seen_y, light)) words[size_t{light} * grid.tile_count() + tile] &= ~bit;
    }
  return words;
}

Result<Reprojection> Reprojection::create(const BlockingFrame& beside) {
  Reprojection made;
  auto raster = BlockingFrame::create_beside(beside, {"gbuffer", "ids", "readback_ids"});
  if (!raster) return raster.error();
  auto finder = BlockingFrame::create_beside(beside, {"predict", "readback_sources"});
  if (!finder) return finder.error();
  auto shader =
      BlockingFrame::create_beside(beside, {"gbuffer", "ids", "predict", "shade_predicted", "readback_color"});
  if (!shader) return shader.error();
  made.raster_ = std::move(*raster);
  made.finder_ = std::move(*finder);
  made.shader_ = std::move(*shader);
  return made;
}

Result<RasterView> Reprojection::rasterise(const CameraView& camera, uint32_t width, uint32_t height,
                                           scenes::SceneTime time) {
  const auto grid = raster_->reserve(width, height, time);
  if (!grid) return grid.error();
  if (auto rendered = raster_->render(camera, *grid); !rendered) return rendered.error();
  return RasterView{camera, width, height, time, copied(raster_->host(resource::kHostIds), size_t{width} * height)};
}

Result<SeenMasks> Reprojection::see(const CameraView& camera, const TileMaskView& masks, scenes::SceneTime time) {
  const uint32_t lights = raster_->scene().light_count();
  if (masks.grid.lights != lights || masks.words.size() != masks.grid.word_count())
    return Error{"a mask of " + std::to_string(masks.grid.lights) + " lights for a scene of " +
                 std::to_string(lights)};
  auto raster = rasterise(camera, masks.grid.width, masks.grid.height, time);
  if (!raster) return raster.error();
  return SeenMasks{std::move(*raster), masks.grid, {masks.words.begin(), masks.words.end()}};
}

// Makes room, also for what is uploaded, which has the seen view's size: memory only grows.
Result<TileGrid> Reprojection::reserve(BlockingFrame& frame, const RasterView& seen, uint32_t width,
                                       uint32_t height) {
  if (auto room = frame.reserve(seen.width, seen.height, seen.time); !room) return room.error();
  const auto grid = frame.reserve(width, height, seen.time);
  if (!grid) return grid.error();
  const SeenView view(seen.camera, seen.width, seen.height);
  copy_into(frame.host(resource::kSeenView), std::as_bytes(std::span(&view, 1)));
  copy_into(frame.host(resource::kSeenIds), std::as_bytes(std::span(seen.ids)));
  return *grid;
}

Result<std::vector<uint32_t>> Reprojection::sources(const RasterView& view, const RasterView& seen) {
  const auto grid = reserve(*finder_, seen, view.width, view.height);
  if (!grid) return grid.error();
  copy_into(finder_->host(resource::kIds), std::as_bytes(std::span(view.ids)));
  if (auto rendered = finder_->render(view.camera, *grid); !rendered) return rendered.error();
  return copied(finder_->host(resource::kHostSources), view.ids.size());
}

Result<std::span<const std::byte>> Reprojection::shade(const CameraView& camera, uint32_t width, uint32_t height,
                                                       const SeenMasks& seen, std::span<const std::byte> shading) {
  const auto grid = reserve(*shader_, seen.raster, width, height);
  if (!grid) return grid.error();
  copy_into(shader_->host(resource::kShading), shading);
  copy_into(shader_->host(resource::kGivenMasks), std::as_bytes(std::span(seen.words)));
  if (auto rendered = shader_->render(camera, *grid); !rendered) return rendered.error();
  return std::span<const std::byte>(
      shader_->host(resource::kHostColor).first(size_t{width} * height * sizeof(uint32_t)));
}

}  // namespace gnomon::gpu
