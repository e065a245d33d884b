#include "tests/bench/client_shares.h"

#include <cmath>

namespace gnomon::bench {
namespace {

// The same surfaces, white, which give and get no light but the ambient one of options.
scenes::ScenePtr white(const scenes::Scene& scene) {
  auto made = std::make_shared<scenes::Scene>(scene);
  for (scenes::Material& material : made->materials) {
    material.base_color = glm::vec4(glm::vec3(1), material.base_color.a);
    material.emissive = glm::vec3(0);
  }
  for (scenes::Texture& texture : made->textures)
    for (size_t i = 0; i < texture.rgba.size(); ++i)
      if (i % 4 != 3) texture.rgba[i] = 255;
  for (scenes::Light& light : made->lights) light.intensity = 0;
  made->surroundings = {};
  return made;
}

float linear(std::byte srgb) {
  const double c = std::to_integer<int>(srgb) / 255.0;
  return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

}  // namespace

LightPlanes planes_of(const scenes::Scene& scene, SampleCounts samples) {
  std::vector<bool> is_area;
  for (const scenes::Light& light : scene.lights) is_area.push_back(light.area.shape != scenes::LightShape::point);
  return {is_area, samples};
}

Result<ClientShares> ClientShares::create(const std::string& device, const scenes::ScenePtr& scene) {
  gpu::RendererOptions options;
  options.device = device;
  auto view = gpu::ReferenceView::create(options, white(*scene));
  if (!view) return view.error();
  ClientShares made;
  made.scene_ = scene;
  made.view_ = std::move(*view);
  return made;
}

Result<void> ClientShares::see(gpu::SurfaceProbe& probe, double seconds, PictureSize size, SampleCounts samples) {
  const auto reprojection = view_->reprojection();
  if (!reprojection) return reprojection.error();
  std::vector<gpu::SeenMasks> masks;  // the newest first
  for (uint32_t before = 0; before <= gpu::kMostEarlierMasks; ++before) {
    const gpu::CameraView camera = camera_on_path(*scene_, seconds - before / kFrameHz, size);
    const auto frame = probe.render(camera, size.width, size.height, {}, samples);
    if (!frame) return frame.error();
    auto seen = (*reprojection)->see(camera, frame->mask(), {}, planes_of(*scene_, samples));
    if (!seen) return seen.error();
    masks.push_back(std::move(*seen));
  }
  camera_ = masks[0].raster.camera;
  alone_ = accumulated_ = masks[0];
  return (*reprojection)->accumulate(accumulated_, std::span(masks).subspan(1));
}

Result<std::vector<float>> ClientShares::of_light(uint32_t light, Shown shown) {
  gpu::ShadeOptions options;
  options.view = gpu::ShadeOptions::View::material;
  options.only_light = light;
  return shares(options, shown);
}

Result<std::vector<float>> ClientShares::of_ambient(Shown shown) {
  gpu::ShadeOptions options;
  options.ambient = glm::vec3(1);
  return shares(options, shown);
}

Result<std::vector<float>> ClientShares::shares(gpu::ShadeOptions options, Shown shown) {
  options.tonemap = gpu::ShadeOptions::Tonemap::clamp;
  options.planes = alone_.planes;
  options.soft_filter = shown.filtered;
  const gpu::SeenMasks& seen = shown.accumulated ? accumulated_ : alone_;
  const auto picture = view_->show_predicted(camera_, seen.grid.width, seen.grid.height, seen, options);
  if (!picture) return picture.error();
  std::vector<float> made(picture->rgba.size() / 4);
  for (size_t pixel = 0; pixel < made.size(); ++pixel) made[pixel] = linear(picture->rgba[4 * pixel]);
  return made;
}

}  // namespace gnomon::bench
