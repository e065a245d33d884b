#include "tests/eval/path_pictures.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "client/view/client_renderer.h"
#include "gpu/wire/translate.h"
#include "tests/eval/path_errors.h"

namespace gnomon::eval {

using client::Picture;

Result<PathPictures> PathPictures::create(const Plan& plan) {
  gpu::RendererOptions options;
  options.device = plan.device;
  options.tracer_options.cache_folder = plan.cache;
  PathPictures made;
  made.plan_ = plan;
  auto probe = gpu::SurfaceProbe::create(options, plan.scene);
  if (!probe) return probe.error();
  made.probe_ = std::make_unique<gpu::SurfaceProbe>(std::move(*probe));
  auto view = gpu::ReferenceView::create(options, plan.scene);
  if (!view) return view.error();
  made.view_ = std::move(*view);
  const auto first = client::view_of(pose_of(plan.scene, plan.fps, 0), plan.size);
  const auto exposure = made.view_->suggest_exposure(gpu::from_wire(first));
  if (!exposure) return exposure.error();
  made.exposure_ = *exposure;
  return made;
}

Result<PathPictures::Frame> PathPictures::trace(uint32_t number) {
  Frame frame;
  frame.number = number;
  frame.camera = client::view_of(pose_of(plan_.scene, plan_.fps, number), plan_.size, centred(plan_.size));
  const gpu::CameraView camera = gpu::from_wire(frame.camera);
  const auto probed = probe_->render(camera, plan_.size.traced_width(), plan_.size.traced_height());
  if (!probed) return probed.error();
  const auto reprojection = view_->reprojection();
  if (!reprojection) return reprojection.error();
  auto seen = (*reprojection)->see(camera, probed->mask(), {});
  if (!seen) return seen.error();
  frame.seen = std::move(*seen);
  return frame;
}

// Both ways by reprojection: of itself, every pixel finds itself.
Result<Picture> PathPictures::shade(const Frame& now, const Frame& seen) {
  gpu::ShadeOptions options;
  options.exposure = exposure_;
  const auto& size = plan_.size;
  auto image =
      view_->predict(gpu::from_wire(shown_part(now.camera, size)), size.width, size.height, seen.seen, options);
  if (!image) return image.error();
  Picture picture;
  picture.width = image->width;
  picture.height = image->height;
  picture.rgba = std::move(image->rgba);
  return picture;
}

namespace {

Picture difference(const Picture& fresh, const Picture& predicted) {
  Picture out(fresh.width, fresh.height);
  for (size_t i = 0; i < fresh.rgba.size(); i += 4) {
    int most = 0;
    for (size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(int{fresh.rgba[i + c]} - int{predicted.rgba[i + c]}));
    const int grey = (fresh.rgba[i] + fresh.rgba[i + 1] + fresh.rgba[i + 2]) / 6;
    out.rgba[i] = static_cast<uint8_t>(most > 2 ? 255 : grey);
    out.rgba[i + 1] = out.rgba[i + 2] = static_cast<uint8_t>(most > 2 ? 255 - std::min(255, 64 + 2 * most) : grey);
    out.rgba[i + 3] = 255;
  }
  return out;
}

void append_rgb(std::ofstream& file, const Picture& picture) {
  std::vector<char> rgb(picture.rgba.size() / 4 * 3);
  for (size_t from = 0, to = 0; from < picture.rgba.size(); from += 4)
    for (size_t c = 0; c < 3; ++c) rgb[to++] = static_cast<char>(picture.rgba[from + c]);
  file.write(rgb.data(), static_cast<std::streamsize>(rgb.size()));
}

}  // namespace

Result<void> PathPictures::write_example(uint32_t frame, uint32_t x, const std::string& prefix) {
  auto before = trace(frame - std::min(frame, x));
  if (!before) return before.error();
  auto now = trace(frame);
  if (!now) return now.error();
  const auto fresh = shade(*now, *now), predicted = shade(*now, *before);
  if (!fresh) return fresh.error();
  if (!predicted) return predicted.error();
  if (auto w = write_png(prefix + "-fresh.png", *fresh); !w) return w;
  if (auto w = write_png(prefix + "-predicted.png", *predicted); !w) return w;
  return write_png(prefix + "-difference.png", difference(*fresh, *predicted));
}

Result<void> PathPictures::write_videos(uint32_t first, uint32_t count, const std::vector<uint32_t>& every_x,
                                        const std::string& prefix, const std::function<void(uint32_t done)>& said) {
  std::vector<std::ofstream> files;
  for (const uint32_t x : every_x) files.emplace_back(prefix + "-" + std::to_string(x) + ".rgb", std::ios::binary);
  std::deque<Frame> frames;  // the newest last
  for (uint32_t i = 0; i < count; ++i) {
    auto now = trace(first + i);
    if (!now) return now.error();
    frames.push_back(std::move(*now));
    if (frames.size() > kMostAhead + 1) frames.pop_front();
    for (size_t k = 0; k < every_x.size(); ++k) {
      const size_t back = std::min<size_t>(every_x[k], frames.size() - 1);
      const auto picture = shade(frames.back(), frames[frames.size() - 1 - back]);
      if (!picture) return picture.error();
      append_rgb(files[k], *picture);
    }
    said(i + 1);
  }
  for (auto& file : files)
    if (!file.flush()) return Error{"cannot write " + prefix};
  return {};
}

}  // namespace gnomon::eval
