#include "client/view/own_view.h"

#include <utility>

namespace gnomon::client {

gpu::CameraView to_gpu(const protocol::CameraView& camera) {
  const auto& p = camera.position;
  const auto& q = camera.orientation;
  return {.position = {p[0], p[1], p[2]},
          .orientation = glm::quat(q[3], q[0], q[1], q[2]),
          .tan_left = camera.tan_left,
          .tan_right = camera.tan_right,
          .tan_up = camera.tan_up,
          .tan_down = camera.tan_down,
          .near_plane = camera.near_plane};
}

scenes::Light to_scene(const protocol::LightInfo& info) {
  const auto vec3 = [](const protocol::Vec3& v) { return glm::vec3(v[0], v[1], v[2]); };
  scenes::Light light;
  switch (info.kind) {
    case protocol::LightKind::point: light.type = scenes::LightType::point; break;
    case protocol::LightKind::spot: light.type = scenes::LightType::spot; break;
    case protocol::LightKind::directional: light.type = scenes::LightType::directional; break;
  }
  light.position = vec3(info.position);
  light.direction = vec3(info.direction);
  light.color = vec3(info.color);
  light.intensity = info.intensity;
  light.range = info.range;
  light.inner_cone_cos = info.inner_cone_cos;
  light.outer_cone_cos = info.outer_cone_cos;
  return light;
}

Result<OwnView> OwnView::create(const scenes::ScenePtr& scene, const std::string& device) {
  gpu::RendererOptions options;
  options.device = device;
  auto view = gpu::ReferenceView::create(options, scene);
  if (!view) return view.error();
  OwnView own;
  own.view_ = std::move(*view);
  return own;
}

Result<Picture> OwnView::shade(const FlownFrame& frame) {
  if (!exposure_) {
    const auto exposure = view_->suggest_exposure(to_gpu(frame.camera));
    if (!exposure) return exposure.error();
    exposure_ = *exposure;
  }
  gpu::ShadeOptions options;
  options.exposure = *exposure_;
  return render(frame, options);
}

Result<std::vector<Picture>> OwnView::seen_by_lights(const FlownFrame& frame) {
  gpu::ShadeOptions options;
  options.view = gpu::ShadeOptions::View::material;
  options.tonemap = gpu::ShadeOptions::Tonemap::clamp;
  std::vector<Picture> pictures;
  for (uint32_t light = 0; light < frame.mask.grid.lights; ++light) {
    options.only_light = light;
    auto picture = render(frame, options);
    if (!picture) return picture.error();
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

Result<void> OwnView::take_lights(const FlownFrame& frame) {
  if (frame.lights == lights_ || frame.lights.empty()) return {};
  std::vector<scenes::Light> lights;
  for (const protocol::LightInfo& light : frame.lights) lights.push_back(to_scene(light));
  if (auto set = view_->set_lights(lights); !set) return set;
  lights_ = frame.lights;
  return {};
}

Result<Picture> OwnView::render(const FlownFrame& frame, gpu::ShadeOptions options) {
  if (auto taken = take_lights(frame); !taken) return taken.error();
  options.time = scenes::SceneTime(frame.mask.moment.scene_time_us);
  const TileGrid& grid = frame.mask.grid;
  auto image = view_->render(to_gpu(frame.camera), grid.width, grid.height, frame.mask.mask(), options);
  if (!image) return image.error();
  Picture picture;
  picture.width = image->width;
  picture.height = image->height;
  picture.rgba = std::move(image->rgba);
  return picture;
}

}  // namespace gnomon::client
