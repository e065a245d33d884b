#include "tests/eval/path_errors.h"

#include <cstring>
#include <deque>
#include <future>

#include "client/media/camera_path.h"
#include "client/view/client_renderer.h"
#include "gpu/passes/passes.h"
#include "gpu/picture/reprojection.h"
#include "gpu/wire/translate.h"

namespace gnomon::eval {
namespace {

using client::BorderPlace;
using client::LightBits;
using client::PixelRect;
using client::ViewSize;

constexpr uint32_t kFullWidth = 1920, kFullHeight = 1080;

// A frame of the path with all that is known of it.
struct PathFrame {
  uint32_t number = 0;
  scenes::CameraPose before, pose;  // of the last frame, and its own
  gpu::RasterView traced, shown;    // with the widest border, and without any
  LightBits masks, valid_bits;
};

template <class T>
std::vector<T> copied(std::span<const std::byte> bytes, size_t count) {
  std::vector<T> out(count);
  if (count > 0) std::memcpy(out.data(), bytes.data(), count * sizeof(T));
  return out;
}

class PathRenderer {
 public:
  static Result<PathRenderer> create(const scenes::ScenePtr& scene, const PathPlan& plan) {
    gpu::RendererOptions options;
    options.device = plan.device;
    options.tracer_options.cache_folder = plan.cache;
    auto frame = gpu::BlockingFrame::create(
        options, {"gbuffer", "ids", "trace", "readback_ids", "readback_masks", "readback_valid_bits"}, scene);
    if (!frame) return frame.error();
    auto reprojection = gpu::Reprojection::create(**frame);
    if (!reprojection) return reprojection.error();
    PathRenderer made;
    made.scene_ = scene;
    made.plan_ = plan;
    made.frame_ = std::move(*frame);
    made.reprojection_.emplace(std::move(*reprojection));
    return made;
  }

  const gpu::PhysicalDevice& device() const { return frame_->device().info(); }
  gpu::Reprojection& reprojection() { return *reprojection_; }

  Result<PathFrame> render(uint32_t number) {
    PathFrame out;
    out.number = number;
    out.pose = pose_of(scene_, plan_.fps, number);
    out.before = number > 0 ? pose_of(scene_, plan_.fps, number - 1) : out.pose;
    const ViewSize& size = plan_.size;
    const protocol::CameraView view = client::view_of(out.pose, size, centred(size));
    const auto grid = frame_->reserve(size.traced_width(), size.traced_height());
    if (!grid) return grid.error();
    if (auto rendered = frame_->render(gpu::from_wire(view), *grid); !rendered) return rendered.error();
    const auto ids = copied<uint32_t>(frame_->host(gpu::resource::kHostIds), size_t{grid->width} * grid->height);
    auto traced = reprojection_->raster_of(gpu::from_wire(view), grid->width, grid->height, ids);
    if (!traced) return traced.error();
    auto shown = shown_part(ids, view);
    if (!shown) return shown.error();
    out.traced = std::move(*traced);
    out.shown = std::move(*shown);
    out.masks = bits(*grid, gpu::resource::kHostMasks);
    out.valid_bits = bits(*grid, gpu::resource::kHostValidBits);
    return out;
  }

 private:
  LightBits bits(const TileGrid& grid, std::string_view resource) {
    const auto words = copied<uint64_t>(frame_->host(resource), grid.word_count());
    return LightBits({grid, words});
  }

  // The picture without border, of the same triangles.
  Result<gpu::RasterView> shown_part(const std::vector<uint32_t>& traced, const protocol::CameraView& view) {
    const ViewSize& size = plan_.size;
    const BorderPlace place = centred(size);
    std::vector<uint32_t> ids(size_t{size.width} * size.height);
    for (uint32_t y = 0; y < size.height; ++y)
      std::copy_n(&traced[size_t{place.top + y} * size.traced_width() + place.left], size.width,
                  &ids[size_t{y} * size.width]);
    return reprojection_->raster_of(gpu::from_wire(client::shown_part(view, size)), size.width, size.height, ids);
  }

  scenes::ScenePtr scene_;
  PathPlan plan_;
  std::unique_ptr<gpu::BlockingFrame> frame_;
  std::optional<gpu::Reprojection> reprojection_;
};

// What of the widest buffer a client with that border would have had, if it expected its masks `x` frames later.
PixelRect window_of(const PathPlan& plan, const Border& border, const PathFrame& seen, uint32_t x) {
  const ViewSize size{plan.size.width, plan.size.height, border.x, border.y};
  const BorderPlace widest = centred(plan.size);
  const BorderPlace place =
      border.by_motion
          ? towards(size, seen.pose, client::extrapolate(seen.before, seen.pose, static_cast<float>(x)))
          : centred(size);
  return {widest.left - place.left, widest.top - place.top, size.traced_width(), size.traced_height()};
}

// Bits are counted beside the device's work, each x on a thread of its own.
struct Counting {
  const PathFrame* seen = nullptr;
  std::vector<uint32_t> sources;
  std::future<std::vector<client::PredictionError>> by_border;
};

std::vector<client::PredictionError> count(const PathPlan& plan, const std::vector<Border>& borders,
                                           const PathFrame& now, const PathFrame& seen,
                                           const std::vector<uint32_t>& sources) {
  const BorderPlace place = centred(plan.size);
  const PixelRect shown{place.left, place.top, plan.size.width, plan.size.height};
  std::vector<client::PredictionError> errors;
  for (const Border& border : borders)
    errors.push_back(compare(seen.masks, sources, window_of(plan, border, seen, now.number - seen.number),
                             now.masks, now.valid_bits.pixels, shown));
  return errors;
}

Result<void> measure(PathRenderer& renderer, const PathPlan& plan, const PathFrame& now,
                     const std::deque<PathFrame>& before, PathErrors& errors) {
  std::deque<Counting> all;
  for (const PathFrame& seen : before) {
    const auto sources = renderer.reprojection().sources(now.shown, seen.traced);
    if (!sources) return sources.error();
    Counting& counting = all.emplace_back(Counting{&seen, {sources->begin(), sources->end()}, {}});
    counting.by_border = std::async(std::launch::async, [&plan, &errors, &now, &counting] {
      return count(plan, errors.borders, now, *counting.seen, counting.sources);
    });
  }
  for (Counting& counting : all) {
    const auto counted = counting.by_border.get();
    const uint32_t x = now.number - counting.seen->number;
    for (size_t b = 0; b < counted.size(); ++b) {
      errors.sums[b][x - 1] += counted[b];
      if (errors.borders[b].name == kKeptBorder) errors.frames[now.number - plan.first][x - 1] = counted[b].share();
    }
  }
  return {};
}

}  // namespace

std::vector<Border> borders_of(uint32_t width, uint32_t height) {
  const auto scaled = [&](const char* name, uint32_t x, uint32_t y, bool by_motion) {
    return Border{name, (x * width + kFullWidth / 2) / kFullWidth, (y * height + kFullHeight / 2) / kFullHeight,
                  by_motion};
  };
  return {scaled("0", 0, 0, false), scaled("64x36", 64, 36, false), scaled("128x72", 128, 72, false),
          scaled("128x72 by motion", 128, 72, true), scaled("640x360", 640, 360, false)};
}

scenes::CameraPose pose_of(const scenes::ScenePtr& scene, double fps, uint32_t i) {
  return client::CameraPath::of_scene(scene).at(i / fps);
}

Result<PathErrors> measure_path(const scenes::ScenePtr& scene, const PathPlan& plan,
                                const std::function<void(uint32_t done)>& said) {
  auto renderer = PathRenderer::create(scene, plan);
  if (!renderer) return renderer.error();
  PathErrors errors;
  errors.lights = static_cast<uint32_t>(scene->lights.size());
  errors.borders = borders_of(plan.size.width, plan.size.height);
  errors.sums.assign(errors.borders.size(), std::vector<client::PredictionError>(kMostAhead));
  errors.frames.assign(plan.count, std::vector<double>(kMostAhead, -1));
  errors.device = renderer->device().name;
  errors.driver = renderer->device().driver;
  std::deque<PathFrame> before;  // by number
  for (uint32_t i = 0; i < plan.count; ++i) {
    // A frame is needed as itself or as one of those before a predicted one.
    const uint32_t next = (i + plan.stride - 1) / plan.stride * plan.stride;
    if (next - i > kMostAhead) continue;
    auto now = renderer->render(plan.first + i);
    if (!now) return now.error();
    if (i % plan.stride == 0)
      if (auto measured = measure(*renderer, plan, *now, before, errors); !measured) return measured.error();
    before.push_back(std::move(*now));
    while (before.front().number + kMostAhead <= plan.first + i) before.pop_front();
    said(i + 1);
  }
  return errors;
}

}  // namespace gnomon::eval
