#include "client/view/debug_view.h"

#include <algorithm>

#include "client/media/montage.h"
#include "client/view/client_renderer.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/wire/translate.h"

namespace gnomon::client {

namespace light_buffer = gpu::light_buffer;

Result<DebugView> DebugView::create(const scenes::ScenePtr& scene, const ViewSize& size, DebugKind kind,
                                    const std::string& device) {
  gpu::RendererOptions options;
  options.device = device;
  auto frame = gpu::BlockingFrame::create(options, {"gbuffer", "surface", "readback_surface"}, scene);
  if (!frame) return frame.error();
  DebugView view;
  view.kind_ = kind;
  view.size_ = size;
  view.frame_ = std::move(*frame);
  for (const scenes::Light& light : scene->lights) view.lights_.push_back(gpu::traced_light(light, scene->bounds));
  if (kind == DebugKind::mask) return view;
  view.mesh_ = scenes::build_world_mesh(*scene);
  view.buffer_ = light_buffer::build(view.mesh_, scene->bounds, view.lights_, {});
  return view;
}

Result<std::vector<Picture>> DebugView::pictures(const ReceivedMasks& frame) {
  const scenes::SceneTime time(frame.mask.moment.scene_time_us);
  const auto grid = frame_->reserve(frame.mask.grid.width, frame.mask.grid.height, time);
  if (!grid) return grid.error();
  if (auto rendered = frame_->render(gpu::from_wire(frame.camera), *grid); !rendered) return rendered.error();
  const auto bytes = frame_->host(gpu::resource::kHostSurface);
  const auto* samples = reinterpret_cast<const gpu::SurfaceSample*>(bytes.data());
  std::vector<Picture> pictures;
  const auto lights = std::min(frame.mask.planes.light_count(), static_cast<uint32_t>(lights_.size()));
  const BorderPlace place = place_of(frame.camera, size_);
  for (uint32_t light = 0; light < lights; ++light)
    pictures.push_back(crop(picture(frame, light, samples), place.left, place.top, size_.width, size_.height));
  return pictures;
}

Picture DebugView::picture(const ReceivedMasks& frame, uint32_t light, const gpu::SurfaceSample* samples) const {
  const TileMaskView mask = frame.mask.mask();
  const auto& eye = frame.camera.position;
  const glm::vec3 camera(eye[0], eye[1], eye[2]);
  Picture picture(mask.grid.width, mask.grid.height);
  for (uint32_t y = 0; y < picture.height; ++y)
    for (uint32_t x = 0; x < picture.width; ++x, ++samples) {
      Colour shown = kNoSurface;
      if (samples->triangle != 0) {
        const auto segment =
            gpu::exact::shadow_segment(camera, {samples->position, samples->normal}, lights_[light]);
        shown = !segment.traced ? kNotAsked
                : kind_ == DebugKind::mask
                    ? mask_colour(frame.mask.seen(x, y, light), frame.mask.planes.samples(light))
                    : colour(segment, light);
      }
      uint8_t* pixel = picture.pixel(x, y);
      std::copy(shown.begin(), shown.end(), pixel);
      pixel[3] = 255;
    }
  return picture;
}

Colour DebugView::colour(const gpu::exact::ShadowSegment& segment, uint32_t light) const {
  const auto answer = light_buffer::query(buffer_, buffer_.lights[light], mesh_, segment);
  return kind_ == DebugKind::bounds ? bounds_colour(answer) : lists_colour(answer.tested);
}

}  // namespace gnomon::client
