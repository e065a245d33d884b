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

Result<Picture> OwnView::material(const FlownFrame& frame) {
  gpu::ShadeOptions options;
  options.view = gpu::ShadeOptions::View::material;
  options.tonemap = gpu::ShadeOptions::Tonemap::clamp;
  return render(frame, options);
}

Result<Picture> OwnView::render(const FlownFrame& frame, const gpu::ShadeOptions& options) {
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
