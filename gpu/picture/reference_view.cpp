#include "gpu/picture/reference_view.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gpu/passes/accumulation.h"
#include "gpu/passes/passes.h"
#include "gpu/passes/shading_uniforms.h"
#include "gpu/picture/blocking_frame.h"

namespace gnomon::gpu {
namespace {

constexpr uint32_t kLuminanceView = 3;
constexpr float kMidGrey = 0.18f;

LightColour light_colour(const scenes::Light& light) {
  LightColour out;
  out.colour = light.color * light.intensity;
  if (light.type == scenes::LightType::spot) {
    out.cone_scale = 1.0f / std::max(0.001f, light.inner_cone_cos - light.outer_cone_cos);
    out.cone_offset = -light.outer_cone_cos * out.cone_scale;
  }
  return out;
}

LightPlanes planes_of(const ResidentScene& scene, const ShadeOptions& options) {
  if (options.planes.light_count() > 0) return options.planes;
  return LightPlanes(std::vector<bool>(scene.light_count()), 1);
}

ShadingUniforms uniforms_of(const ResidentScene& scene, const ShadeOptions& options) {
  const scenes::Surroundings& around = scene.scene().surroundings;
  ShadingUniforms out{};
  out.ambient_above = options.ambient + around.ambient_above;
  out.ambient_below = options.ambient + around.ambient_below;
  out.has_sky = around.has_sky;
  out.sky_zenith = around.sky_zenith;
  out.sky_horizon = around.sky_horizon;
  out.sky_ground = around.sky_ground;
  out.sky_clouds = around.sky_clouds;
  out.exposure = options.exposure;
  out.background = options.background;
  out.view = static_cast<uint32_t>(options.view);
  out.tonemap = static_cast<uint32_t>(options.tonemap);
  out.only_light = options.only_light.value_or(kEveryLight);
  std::transform(scene.lights().begin(), scene.lights().end(), out.lights, light_colour);
  const LightPlanes planes = planes_of(scene, options);
  for (uint32_t light = 0; light < planes.light_count(); ++light) {
    out.lights[light].first_plane = planes.first(light);
    out.lights[light].samples = planes.samples(light);
    out.lights[light].number = out.occlusion_number;
    out.occlusion_number += planes.samples(light) > 1;
  }
  out.occlusion = static_cast<uint32_t>(planes.occlusion());
  out.occlusion_plane = planes.first_of_occlusion();
  out.window_step = options.samples == Samples::four ? 2 : 1;
  if (options.soft_filter) out.filter_step = out.window_step;
  return out;
}

Result<void> check_planes(const ResidentScene& scene, const TileGrid& grid, const ShadeOptions& options) {
  const LightPlanes planes = planes_of(scene, options);
  if (planes.light_count() == scene.light_count() && planes.total() == grid.planes) return {};
  return Error{"a mask of " + std::to_string(grid.planes) + " planes for a scene of " +
               std::to_string(scene.light_count()) + " lights with " + std::to_string(planes.total()) + " planes"};
}

}  // namespace

RgbaImage RgbaView::copy() const {
  RgbaImage image{width, height, {}};
  const auto* bytes = reinterpret_cast<const uint8_t*>(rgba.data());
  image.rgba.assign(bytes, bytes + rgba.size());
  return image;
}

// Renders frames of the passes gbuffer and shade, and fills in their host inputs.
class ReferenceView::Shader {
 public:
  explicit Shader(std::unique_ptr<BlockingFrame> frame) : frame_(std::move(frame)) {}

  ResidentScene& scene() { return frame_->scene(); }
  const BlockingFrame& frame() const { return *frame_; }

  // Four bytes a pixel, valid until the next call.
  Result<std::span<const std::byte>> render(const CameraView& camera, const TileMaskView& masks,
                                            const ShadingUniforms& shading, scenes::SceneTime time) {
    const auto grid = frame_->reserve_given(masks.grid, time);
    if (!grid) return grid.error();
    if (masks.words.size() != grid->word_count()) return Error{"a mask of another size than it says"};
    std::memcpy(frame_->host(resource::kShading).data(), &shading, sizeof(shading));
    if (!masks.words.empty())
      std::memcpy(frame_->host(resource::kUploadedMasks).data(), masks.words.data(), masks.words.size_bytes());
    if (auto rendered = frame_->render(camera, *grid); !rendered) return rendered.error();
    const size_t bytes = size_t{grid->width} * grid->height * sizeof(uint32_t);
    return std::span<const std::byte>(frame_->host(resource::kHostColor).first(bytes));
  }

 private:
  std::unique_ptr<BlockingFrame> frame_;
};

ReferenceView::ReferenceView(std::unique_ptr<Shader> shader) : shader_(std::move(shader)) {}
ReferenceView::~ReferenceView() = default;

Result<std::unique_ptr<ReferenceView>> ReferenceView::create(const RendererOptions& options,
                                                             const scenes::ScenePtr& scene) {
  auto frame = BlockingFrame::create(options, {"gbuffer", "upload_masks", "shade", "readback_color"}, scene);
  if (!frame) return frame.error();
  return std::unique_ptr<ReferenceView>(new ReferenceView(std::make_unique<Shader>(std::move(*frame))));
}

Result<RgbaImage> ReferenceView::render(const CameraView& camera, uint32_t width, uint32_t height,
                                        const TileMaskView& masks, const ShadeOptions& options) {
  const auto shown = show(camera, width, height, masks, options);
  if (!shown) return shown.error();
  return shown->copy();
}

Result<RgbaImage> ReferenceView::predict(const CameraView& camera, uint32_t width, uint32_t height,
                                         const SeenMasks& seen, const ShadeOptions& options) {
  const auto shown = show_predicted(camera, width, height, seen, options);
  if (!shown) return shown.error();
  return shown->copy();
}

Result<RgbaView> ReferenceView::show(const CameraView& camera, uint32_t width, uint32_t height,
                                     const TileMaskView& masks, const ShadeOptions& options) {
  if (masks.grid.width != width || masks.grid.height != height)
    return Error{"a mask of another size than the picture's"};
  if (auto fits = check_planes(shader_->scene(), masks.grid, options); !fits) return fits.error();
  const auto pixels = shader_->render(camera, masks, uniforms_of(shader_->scene(), options), options.time);
  if (!pixels) return pixels.error();
  return RgbaView{width, height, *pixels};
}

Result<RgbaView> ReferenceView::show_predicted(const CameraView& camera, uint32_t width, uint32_t height,
                                               const SeenMasks& seen, const ShadeOptions& options) {
  if (auto fits = check_planes(shader_->scene(), seen.grid, options); !fits) return fits.error();
  const auto reprojected = reprojection();
  if (!reprojected) return reprojected.error();
  auto shading = uniforms_of(shader_->scene(), options);
  if (seen.shares) shading.whole_share = kWholeShare;
  const auto pixels =
      (*reprojected)->shade(camera, width, height, seen, std::as_bytes(std::span(&shading, 1)), options.samples);
  if (!pixels) return pixels.error();
  return RgbaView{width, height, *pixels};
}

Result<Reprojection*> ReferenceView::reprojection() {
  if (!reprojection_) {
    auto made = Reprojection::create(shader_->frame());
    if (!made) return made.error();
    reprojection_ = std::move(*made);
  }
  return &*reprojection_;
}

Result<void> ReferenceView::set_lights(const std::vector<scenes::Light>& lights) {
  return shader_->scene().set_lights(lights);
}

Result<float> ReferenceView::suggest_exposure(const CameraView& camera) {
  const TileGrid grid{160, 96, shader_->scene().light_count()};
  const std::vector<uint64_t> all_lit(grid.word_count(), ~uint64_t{0});
  ShadingUniforms shading = uniforms_of(shader_->scene(), {});
  shading.view = kLuminanceView;
  const auto pixels = shader_->render(camera, {grid, all_lit}, shading, {});
  if (!pixels) return pixels.error();
  std::vector<float> luminance(pixels->size() / sizeof(float));
  std::memcpy(luminance.data(), pixels->data(), pixels->size());
  // The geometric mean, so that a lamp in view hardly affects the exposure.
  double sum = 0;
  size_t surfaces = 0;
  for (const float l : luminance) {
    if (!(l > 0.0f) || !std::isfinite(l)) continue;
    sum += std::log(static_cast<double>(l));
    ++surfaces;
  }
  if (surfaces == 0) return 1.0f;
  return kMidGrey / static_cast<float>(std::exp(sum / static_cast<double>(surfaces)));
}

}  // namespace gnomon::gpu
