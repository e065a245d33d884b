#include "gpu/picture/reprojection.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "gpu/passes/passes.h"
#include "gpu/passes/seen_view.h"

namespace gnomon::gpu {
namespace {

constexpr size_t kBuffersKept = 16;

void copy_into(std::span<std::byte> target, std::span<const std::byte> source) {
  if (!source.empty()) std::memcpy(target.data(), source.data(), source.size());
}

uint64_t bytes_of(const TileGrid& grid) { return uint64_t{grid.width} * grid.height * sizeof(uint32_t); }

bool same_eye(const CameraView& a, const CameraView& b) {
  return a.position == b.position && a.orientation == b.orientation;
}

void give_seen(BlockingFrame& frame, const RasterView& seen, bool from_same_eye = false) {
  SeenView view(seen.camera, seen.width, seen.height);
  view.same_eye = from_same_eye;
  copy_into(frame.host(resource::kSeenView), std::as_bytes(std::span(&view, 1)));
  frame.give(resource::kSeenIds, *seen.ids);
}

// `scene`: whose lights the planes are of.
Accumulation accumulation_of(const LightPlanes& planes, const ResidentScene& scene, uint32_t earlier) {
  Accumulation made;
  made.earlier = earlier;
  made.resting_triangles = scene.triangle_count();
  for (uint32_t light = 0; light < planes.light_count(); ++light) {
    if (planes.samples(light) == 1) continue;
    const bool rests = scene.scene().lights[light].moved_by == scenes::kNone;
    made.counted[made.numbers++] = {planes.first(light), planes.samples(light), 1, rests};
  }
  if (const Occlusion occlusion = planes.occlusion(); occlusion != Occlusion::none)
    made.counted[made.numbers++] = {planes.first_of_occlusion(), kOcclusionSegments,
                                    occlusion == Occlusion::half ? 2u : 1u, 1};
  return made;
}

// What is left without an earlier mask is bound to the newest, and not looked at.
void give_earlier(BlockingFrame& frame, const SeenMasks& newest, std::span<const SeenMasks> earlier) {
  std::array<SeenView, kMostEarlierMasks> views;
  for (size_t i = 0; i < kMostEarlierMasks; ++i) {
    const SeenMasks& masks = i < earlier.size() ? earlier[i] : newest;
    views[i] = SeenView(masks.raster.camera, masks.raster.width, masks.raster.height);
    frame.give(resource::kEarlierIds[i], *masks.raster.ids);
    frame.give(resource::kEarlierMasks[i], *masks.words);
  }
  copy_into(frame.host(resource::kEarlierViews), std::as_bytes(std::span(views)));
}

}  // namespace

std::vector<uint64_t> masks_by_sources(const TileMaskView& seen, std::span<const uint32_t> sources, uint32_t width,
                                       uint32_t height) {
  const TileGrid grid{width, height, seen.grid.planes};
  std::vector<uint64_t> words(grid.word_count(), ~uint64_t{0});
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t source = sources[size_t{y} * width + x];
      if (source == 0) continue;
      const uint32_t seen_x = (source - 1) % seen.grid.width, seen_y = (source - 1) / seen.grid.width;
      const size_t tile = size_t{y / kTileSize} * grid.tiles_x() + x / kTileSize;
      const uint64_t bit = uint64_t{1} << (y % kTileSize * kTileSize + x % kTileSize);
      for (uint32_t plane = 0; plane < grid.planes; ++plane)
        if (!seen.lit(seen_x, seen_y, plane)) words[size_t{plane} * grid.tile_count() + tile] &= ~bit;
    }
  return words;
}

Result<Reprojection> Reprojection::create(const BlockingFrame& beside) {
  Reprojection made;
  made.device_ = beside.device_ptr();
  auto seer = BlockingFrame::create_beside(beside, {"gbuffer", "keep_ids", "keep_masks"});
  if (!seer) return seer.error();
  auto shader =
      BlockingFrame::create_beside(beside, {"gbuffer", "ids", "predict", "shade_predicted", "readback_color"});
  if (!shader) return shader.error();
  made.seer_ = std::move(*seer);
  made.shader_ = std::move(*shader);
  return made;
}

Result<BlockingFrame*> Reprojection::when_needed(std::unique_ptr<BlockingFrame>& frame,
                                                 const std::vector<std::string>& passes) {
  if (!frame) {
    auto made = BlockingFrame::create_beside(*seer_, passes);
    if (!made) return made.error();
    frame = std::move(*made);
  }
  return frame.get();
}

// Reuses a buffer of that size that nobody else holds, or makes one. Reuse is safe, because all work that reads or
// writes the buffer was submitted before what is rendered next. A client needs few buffers, of two or three sizes.
Result<std::shared_ptr<Buffer>> Reprojection::buffer(uint64_t bytes) {
  bytes = std::max<uint64_t>(bytes, 16);
  for (const auto& one : buffers_)
    if (one.use_count() == 1 && one->bytes() == bytes) return one;
  auto made = Buffer::create(device_, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::device);
  if (!made) return made.error();
  if (buffers_.size() >= kBuffersKept)
    std::erase_if(buffers_, [](const auto& one) { return one.use_count() == 1; });
  buffers_.push_back(std::make_shared<Buffer>(std::move(*made)));
  return buffers_.back();
}

Result<RasterView> Reprojection::rasterise(BlockingFrame& frame, const TileGrid& grid, const CameraView& camera,
                                           scenes::SceneTime time) {
  auto ids = buffer(bytes_of(grid));
  if (!ids) return ids.error();
  frame.give(resource::kIds, **ids);
  if (auto begun = frame.start(camera, grid); !begun) return begun.error();
  return RasterView{camera, grid.width, grid.height, time, std::move(*ids)};
}

Result<RasterView> Reprojection::rasterise(const CameraView& camera, uint32_t width, uint32_t height,
                                           scenes::SceneTime time) {
  const auto frame = when_needed(raster_, {"gbuffer", "keep_ids"});
  if (!frame) return frame.error();
  const auto grid = (*frame)->reserve(width, height, time);
  if (!grid) return grid.error();
  return rasterise(**frame, *grid, camera, time);
}

Result<RasterView> Reprojection::raster_of(const CameraView& camera, uint32_t width, uint32_t height,
                                           std::span<const uint32_t> ids) {
  auto buffer = upload(device_, std::as_bytes(ids));
  if (!buffer) return buffer.error();
  return RasterView{camera, width, height, {}, std::make_shared<Buffer>(std::move(*buffer))};
}

Result<SeenMasks> Reprojection::see(const CameraView& camera, const TileMaskView& masks, scenes::SceneTime time,
                                    const LightPlanes& planes) {
  const uint32_t lights = seer_->scene().light_count();
  const bool of_scene = planes.light_count() == 0
                            ? masks.grid.planes == lights
                            : planes.light_count() == lights && planes.total() == masks.grid.planes;
  if (!of_scene || masks.words.size() != masks.grid.word_count())
    return Error{"a mask of " + std::to_string(masks.grid.planes) + " planes for a scene of " +
                 std::to_string(lights) + " lights"};
  const auto grid = seer_->reserve_given(masks.grid, time);
  if (!grid) return grid.error();
  auto words = buffer(masks.words.size_bytes());
  if (!words) return words.error();
  seer_->give(resource::kGivenMasks, **words);
  copy_into(seer_->host(resource::kUploadedMasks), std::as_bytes(masks.words));
  auto raster = rasterise(*seer_, *grid, camera, time);
  if (!raster) return raster.error();
  return SeenMasks{std::move(*raster), masks.grid, std::move(*words), planes};
}

Result<void> Reprojection::accumulate(SeenMasks& newest, std::span<const SeenMasks> earlier) {
  const uint32_t numbers = counted_numbers(newest.planes);
  if (earlier.empty() || numbers == 0) return {};
  if (earlier.size() > kMostEarlierMasks)
    return Error{"more than " + std::to_string(kMostEarlierMasks) + " masks before the newest"};
  for (const SeenMasks& masks : earlier)
    if (masks.grid != newest.grid || masks.planes != newest.planes)
      return Error{"masks of several shapes do not accumulate"};
  const auto frame = when_needed(accumulator_, {"accumulate"});
  if (!frame) return frame.error();
  const TileGrid& size = newest.grid;
  auto shares = buffer(share_bytes(size.width, size.height, numbers));
  if (!shares) return shares.error();
  const auto grid = (*frame)->reserve_given(size, newest.raster.time);
  if (!grid) return grid.error();
  const Accumulation accumulation =
      accumulation_of(newest.planes, seer_->scene(), static_cast<uint32_t>(earlier.size()));
  copy_into((*frame)->host(resource::kAccumulation), std::as_bytes(std::span(&accumulation, 1)));
  (*frame)->give(resource::kIds, *newest.raster.ids);
  (*frame)->give(resource::kGivenMasks, *newest.words);
  (*frame)->give(resource::kShares, **shares);
  give_earlier(**frame, newest, earlier);
  if (auto begun = (*frame)->start(newest.raster.camera, *grid); !begun) return begun;
  newest.shares = std::move(*shares);
  return {};
}

Result<void> Reprojection::give_shares(SeenMasks& masks, std::span<const uint32_t> shares) {
  if (shares.size_bytes() != share_bytes(masks.grid.width, masks.grid.height, counted_numbers(masks.planes)))
    return Error{"shares of another number of pixels or of planes"};
  auto buffer = upload(device_, std::as_bytes(shares));
  if (!buffer) return buffer.error();
  masks.shares = std::make_shared<Buffer>(std::move(*buffer));
  return {};
}

Result<std::span<const uint32_t>> Reprojection::sources(const RasterView& view, const RasterView& seen) {
  if (const auto made = when_needed(finder_, {"predict", "readback_sources"}); !made) return made.error();
  const auto grid = finder_->reserve(view.width, view.height, seen.time);
  if (!grid) return grid.error();
  give_seen(*finder_, seen);
  finder_->give(resource::kIds, *view.ids);
  if (auto rendered = finder_->render(view.camera, *grid); !rendered) return rendered.error();
  const auto* found = reinterpret_cast<const uint32_t*>(finder_->host(resource::kHostSources).data());
  return std::span(found, size_t{view.width} * view.height);
}

Result<std::span<const std::byte>> Reprojection::shade(const CameraView& camera, uint32_t width, uint32_t height,
                                                       const SeenMasks& seen, std::span<const std::byte> shading,
                                                       Samples samples) {
  const bool four = samples == Samples::four;
  if (four) {
    const auto made =
        when_needed(smoother_, {"gbuffer", "ids", "predict", "shade_predicted", "average", "readback_averaged"});
    if (!made) return made.error();
  }
  BlockingFrame& frame = four ? *smoother_ : *shader_;
  const uint32_t each_way = four ? 2 : 1;
  const auto grid = frame.reserve(each_way * width, each_way * height, seen.raster.time);
  if (!grid) return grid.error();
  give_seen(frame, seen.raster, four && same_eye(camera, seen.raster.camera));
  frame.give(resource::kGivenMasks, *seen.words);
  frame.give(resource::kShares, seen.shares ? *seen.shares : *seen.words);
  copy_into(frame.host(resource::kShading), shading);
  if (auto rendered = frame.render(camera, *grid); !rendered) return rendered.error();
  const auto pixels = frame.host(four ? resource::kHostAveraged : resource::kHostColor);
  return std::span<const std::byte>(pixels.first(size_t{width} * height * sizeof(uint32_t)));
}

}  // namespace gnomon::gpu
