#include "client/view/client_renderer.h"

#include <utility>

#include "client/media/montage.h"
#include "client/prediction/prediction_error.h"
#include "gpu/wire/translate.h"

namespace gnomon::client {
namespace {

constexpr uint32_t kTrialStep = 4;  // pixels, each way: predictions are compared at one in 16

}  // namespace

Result<ClientRenderer> ClientRenderer::create(const scenes::ScenePtr& scene, const ViewSize& size,
                                              const Options& options) {
  gpu::RendererOptions renderer;
  renderer.device = options.device;
  auto view = gpu::ReferenceView::create(renderer, scene);
  if (!view) return view.error();
  ClientRenderer own;
  own.view_ = std::move(*view);
  own.size_ = size;
  own.samples_ = options.samples;
  own.soft_filter_ = options.soft_filter;
  own.soft_accumulate_ = options.soft_accumulate;
  return own;
}

Result<PictureView> ClientRenderer::draw(const Showing& showing, gpu::Samples samples) {
  if (!exposure_) {
    const auto exposure = view_->suggest_exposure(gpu::from_wire(showing.camera));
    if (!exposure) return exposure.error();
    exposure_ = *exposure;
  }
  gpu::ShadeOptions options;
  options.exposure = *exposure_;
  options.soft_filter = soft_filter_;
  options.samples = samples;
  return render(showing, options);
}

Result<Picture> ClientRenderer::shade(const Showing& showing) {
  const auto drawn = draw(showing, samples_);
  if (!drawn) return drawn.error();
  return copied(*drawn);
}

Result<std::vector<Picture>> ClientRenderer::seen_by_lights(const Showing& showing) {
  gpu::ShadeOptions options;
  options.view = gpu::ShadeOptions::View::material;
  options.tonemap = gpu::ShadeOptions::Tonemap::clamp;
  std::vector<Picture> pictures;
  for (uint32_t light = 0; light < showing.seen->mask.planes.light_count(); ++light) {
    options.only_light = light;
    const auto picture = render(showing, options);
    if (!picture) return picture.error();
    pictures.push_back(copied(*picture));
  }
  return pictures;
}

Result<PictureView> ClientRenderer::render(const Showing& showing, gpu::ShadeOptions options) {
  if (auto taken = take(showing.seen); !taken) return taken.error();
  options.time = scenes::SceneTime(masks_->mask.moment.scene_time_us);
  options.planes = masks_->mask.planes;
  const TileGrid& grid = masks_->mask.grid;
  const auto view_of = [](const gpu::RgbaView& image) {
    return PictureView{image.width, image.height, size_t{4} * image.width,
                       reinterpret_cast<const uint8_t*>(image.rgba.data())};
  };
  // Samples beside a pixel's centre need the masks looked up, as those of another camera do; so do shares that accumulate,
  // which are those of masks that were seen, and masks of another size than was asked for.
  const bool accumulates = soft_accumulate_ && !masks_->mask.planes.is_hard();
  const bool other_size = grid.width != size_.traced_width() || grid.height != size_.traced_height();
  if (showing.reprojected || other_size || accumulates || options.samples == gpu::Samples::four) {
    const auto masks = seen();
    if (!masks) return masks.error();
    const auto shown = view_->show_predicted(gpu::from_wire(shown_part(showing.camera, size_)), size_.width,
                                             size_.height, **masks, options);
    if (!shown) return shown.error();
    return view_of(*shown);
  }
  const auto shown =
      view_->show(gpu::from_wire(showing.camera), grid.width, grid.height, masks_->mask.mask(), options);
  if (!shown) return shown.error();
  const BorderPlace place = place_of(showing.camera, size_);
  return crop(view_of(*shown), place.left, place.top, size_.width, size_.height);
}

Result<void> ClientRenderer::take(const ReceivedPtr& received) {
  if (masks_ && masks_->index == received->index) return {};
  const bool same_lights = received->lights.empty() || received->lights == lights_;
  if (auto taken = take_lights(received->lights); !taken) return taken;
  ReceivedPtr next = received;
  if (!received->mask.complete()) {
    auto completed = std::make_shared<ReceivedMasks>(*received);
    if (auto covered = cover(*completed); !covered) return covered;
    next = std::move(completed);
  }
  keep_for_later(next->mask, same_lights);
  masks_ = std::move(next);
  seen_.reset();
  return {};
}

// Before `next` takes the place of the newest masks, which then count as earlier ones if they are of the same lights.
void ClientRenderer::keep_for_later(const AssembledFrame& next, bool same_lights) {
  if (!same_lights || !masks_ || masks_->mask.grid != next.grid || masks_->mask.planes != next.planes) {
    earlier_.clear();
    return;
  }
  if (!soft_accumulate_ || !seen_) return;
  seen_->shares.reset();
  earlier_.insert(earlier_.begin(), std::move(*seen_));
  if (earlier_.size() > gpu::kMostEarlierMasks) earlier_.pop_back();
}

Result<void> ClientRenderer::take_lights(const std::vector<protocol::LightInfo>& given) {
  if (given == lights_ || given.empty()) return {};
  std::vector<scenes::Light> lights;
  for (const protocol::LightInfo& light : given) lights.push_back(gpu::from_wire(light));
  if (auto set = view_->set_lights(lights); !set) return set;
  lights_ = given;
  return {};
}

// Reprojects missing tiles from the previous masks. Without any, they are lit, as the assembler left them.
Result<void> ClientRenderer::cover(ReceivedMasks& received) {
  AssembledFrame& mask = received.mask;
  if (!masks_ || masks_->mask.planes != mask.planes) return {};
  const auto before = seen();
  if (!before) return before.error();
  gpu::Reprojection& reprojection = **view_->reprojection();
  const auto raster = reprojection.rasterise(gpu::from_wire(received.camera), mask.grid.width, mask.grid.height,
                                             scenes::SceneTime(mask.moment.scene_time_us));
  if (!raster) return raster.error();
  const auto sources = reprojection.sources(*raster, (*before)->raster);
  if (!sources) return sources.error();
  const auto words = gpu::masks_by_sources(masks_->mask.mask(), *sources, mask.grid.width, mask.grid.height);
  // At half size a source pixel may have no count of its own: such tiles stay open.
  const bool all_count = mask.planes.occlusion() != Occlusion::half;
  const size_t covered =
      all_count ? mask.words.size() : size_t{mask.planes.first_of_occlusion()} * mask.grid.tile_count();
  for (size_t word = 0; word < covered; ++word) {
    if (mask.arrived[word]) continue;
    mask.words[word] = words[word];
    ++covered_words_;
  }
  return {};
}

Result<const gpu::SeenMasks*> ClientRenderer::seen() {
  if (seen_) return &*seen_;
  const auto reprojection = view_->reprojection();
  if (!reprojection) return reprojection.error();
  auto seen = (*reprojection)
                  ->see(gpu::from_wire(masks_->camera), masks_->mask.mask(),
                        scenes::SceneTime(masks_->mask.moment.scene_time_us), masks_->mask.planes);
  if (!seen) return seen.error();
  if (soft_accumulate_) {
    if (auto done = (*reprojection)->accumulate(*seen, earlier_); !done) return done.error();
  }
  seen_ = std::move(*seen);
  return &*seen_;
}

Result<std::optional<ClientRenderer::Outcome>> ClientRenderer::outcome(const Showing& showing) {
  if (auto taken = take(showing.seen); !taken) return taken.error();
  if (!trial_) {
    const auto now = seen();
    if (!now) return now.error();
    trial_ = Trial{**now, masks_, showing.newest};
    return std::optional<Outcome>();
  }
  if (masks_->index < trial_->index || !masks_->mask.complete()) return std::optional<Outcome>();
  const Trial trial = std::move(*trial_);
  trial_.reset();
  if (trial.seen.grid != masks_->mask.grid || trial.masks->mask.planes != masks_->mask.planes)
    return std::optional<Outcome>();
  gpu::Reprojection& reprojection = **view_->reprojection();
  const auto raster = reprojection.rasterise(gpu::from_wire(shown_part(masks_->camera, size_)), size_.width,
                                             size_.height, trial.seen.raster.time);
  if (!raster) return raster.error();
  const auto sources = reprojection.sources(*raster, trial.seen.raster);
  if (!sources) return sources.error();
  const BorderPlace place = place_of(masks_->camera, size_);
  const PredictionError error =
      compare_some(trial.masks->mask.mask(), *sources, masks_->mask.mask(),
                   {place.left, place.top, size_.width, size_.height}, kTrialStep, masks_->mask.planes);
  return std::optional<Outcome>(Outcome{trial.masks->camera, masks_->camera, error.share()});
}

}  // namespace gnomon::client
