// Suite "soft_pictures": one view of each scene as the client draws it with hard shadows, with 16 points of each area
// light, with ambient occlusion as well, and with shares of 1,024 points and segments that Embree has found; and how far
// the third is from the last. What each costs to trace and to send stands in the table and in the pictures.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "client/media/label.h"
#include "client/media/montage.h"
#include "gpu/wire/translate.h"
#include "protocol/codec.h"
#include "scenes/light_samples.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/client_shares.h"
#include "tests/bench/embree_shares.h"
#include "tests/bench/parallel_rows.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

using client::Picture;
using nlohmann::ordered_json;

constexpr uint32_t kReference = 1024;
constexpr uint32_t kGain = 4;  // of differences

struct Kind {
  const char* name;
  SampleCounts samples;
};
constexpr std::array<Kind, 3> kKinds{
    Kind{"hard", {1}}, {"soft, 16 points", {16}}, {"soft, occlusion", {16, Occlusion::full}}};

struct Drawn {
  std::string name;
  Picture picture;
  std::optional<double> trace_ms = {};
  std::optional<size_t> bytes = {}, bytes_referring = {};
};

double trace_ms(const gpu::FrameTiming& timing) {
  uint64_t ns = 0;
  for (const gpu::StageTime& stage : timing.stages)
    if (stage.pass.starts_with("trace") || stage.pass == "sample_points") ns += stage.gpu_ns;
  return static_cast<double>(ns) / 1e6;
}

Picture picture_of(gpu::RgbaImage image) {
  Picture picture;
  picture.width = image.width;
  picture.height = image.height;
  picture.rgba = std::move(image.rgba);
  return picture;
}

// Root mean square of the differences of the two pictures' channels, of 255.
double rmse(const Picture& a, const Picture& b) {
  double sum = 0;
  size_t channels = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double off = int{a.rgba[i]} - int{b.rgba[i]};
    sum += off * off;
    ++channels;
  }
  return std::sqrt(sum / static_cast<double>(channels));
}

// One view of one scene.
class View {
 public:
  static Result<View> create(const gpu::RendererOptions& options, const scenes::ScenePtr& scene, double seconds,
                             PictureSize size) {
    auto probe = gpu::SurfaceProbe::create(options, scene);
    if (!probe) return probe.error();
    if (probe->tracer().soft_shader()) {
      say("  building for areas");
      if (auto built = probe->build_areas(); !built) return built.error();
    }
    auto view = gpu::ReferenceView::create(options, scene);
    if (!view) return view.error();
    View made{scene, size, std::move(*probe), std::move(*view)};
    made.camera_ = camera_on_path(*scene, seconds, size);
    made.before_ = camera_on_path(*scene, seconds - 1 / kFrameHz, size);
    const auto exposure = made.view_->suggest_exposure(made.camera_);
    if (!exposure) return exposure.error();
    made.exposure_ = *exposure;
    return made;
  }

  const gpu::Device& device() const { return probe_.device(); }

  // Median of as many frames.
  Result<Drawn> draw(const Kind& kind, uint32_t repeats) {
    say(std::string("  ") + kind.name);
    std::vector<double> ms;
    for (uint32_t repeat = 0; repeat <= repeats; ++repeat) {
      auto frame = trace(camera_, kind.samples);
      if (!frame) return frame.error();
      if (repeat > 0) ms.push_back(trace_ms(frame->timing));  // the first one warms up
      newest_ = std::move(*frame);
    }
    const auto earlier = trace(before_, kind.samples);
    if (!earlier) return earlier.error();
    auto seen = see(newest_, kind.samples);
    if (!seen) return seen.error();
    auto picture = shade(*seen);
    if (!picture) return picture.error();
    Drawn drawn{kind.name, std::move(*picture), median(ms)};
    drawn.bytes = bytes_of(newest_, nullptr);
    const protocol::MaskReference reference(FrameId{1}, earlier->mask(), gpu::to_wire(before_));
    drawn.bytes_referring = bytes_of(newest_, &reference);
    return drawn;
  }

  // After draw() of a kind, with its lights and its occlusion, of as many points and segments as the reference has.
  Result<Drawn> draw_reference(SampleCounts samples) {
    say("  reference");
    auto seen = see(newest_, samples);
    if (!seen) return seen.error();
    const auto reprojection = view_->reprojection();
    if (!reprojection) return reprojection.error();
    if (auto given = (*reprojection)->give_shares(*seen, reference_shares()); !given) return given.error();
    auto picture = shade(*seen);
    if (!picture) return picture.error();
    return Drawn{"reference", std::move(*picture)};
  }

 private:
  View(scenes::ScenePtr scene, PictureSize size, gpu::SurfaceProbe probe, std::unique_ptr<gpu::ReferenceView> view)
      : scene_(std::move(scene)),
        size_(size),
        probe_(std::move(probe)),
        view_(std::move(view)),
        oracle_(std::make_unique<test::EmbreeOracle>(scene_, true)) {}

  Result<gpu::ProbedFrame> trace(const gpu::CameraView& camera, SampleCounts samples) {
    return probe_.render(camera, size_.width, size_.height, {}, samples);
  }

  Result<gpu::SeenMasks> see(const gpu::ProbedFrame& frame, SampleCounts samples) {
    const auto reprojection = view_->reprojection();
    if (!reprojection) return reprojection.error();
    return (*reprojection)->see(camera_, frame.mask(), {}, planes_of(*scene_, samples));
  }

  Result<Picture> shade(const gpu::SeenMasks& seen) {
    gpu::ShadeOptions options;
    options.exposure = exposure_;
    options.planes = seen.planes;
    options.samples = gpu::Samples::four;
    auto image = view_->predict(camera_, size_.width, size_.height, seen, options);
    if (!image) return image.error();
    return picture_of(std::move(*image));
  }

  // By tiles_context.
  size_t bytes_of(const gpu::ProbedFrame& frame, const protocol::MaskReference* reference) {
    const PackedMask packed(frame.mask(), frame.valid_bits);
    protocol::EncodedMask encoded;
    const auto done = encoder_.encode(packed.view(), protocol::CodecId::tiles_context,
                                      protocol::kMaxSlicePayloadBytes, encoded, reference, gpu::to_wire(camera_));
    return done ? encoded.bytes.size() : 0;
  }

  // As gpu/passes/accumulation.h has them: of the area lights in turn, then of ambient light.
  std::vector<uint32_t> reference_shares() const {
    const std::vector<glm::vec3> segments = scenes::occlusion_points(kReference / scenes::kSamplePatterns);
    const float radius = scenes::occlusion_radius(*scene_);
    std::vector<gpu::exact::TracedLight> middles;
    std::vector<std::vector<glm::vec3>> offsets;
    for (const scenes::Light& light : scene_->lights) {
      if (light.area.shape == scenes::LightShape::point) continue;
      middles.push_back(gpu::traced_light(light, scene_->bounds));
      offsets.push_back(scenes::sample_offsets(light.area, kReference / scenes::kSamplePatterns));
    }
    const size_t pixels = size_t{size_.width} * size_.height;
    std::vector<uint32_t> shares(pixels * ((middles.size() + 4) / 4));
    for_rows(size_.height, [&](uint32_t y) {
      for (uint32_t x = 0; x < size_.width; ++x) {
        const gpu::SurfaceSample& sample = newest_.surface_at(x, y);
        if (sample.triangle == 0) continue;
        const auto put = [&](size_t number, float share) {
          const auto units = static_cast<uint32_t>(std::lround(share * static_cast<float>(gpu::kWholeShare)));
          shares[number / 4 * pixels + size_t{y} * size_.width + x] |= units << (8 * (number % 4));
        };
        const gpu::exact::SurfacePoint surface{sample.position, sample.normal};
        for (size_t light = 0; light < middles.size(); ++light) {
          const auto hard = gpu::exact::shadow_segment(camera_.position, surface, middles[light]);
          if (hard.traced)
            put(light, seen_share(*oracle_, sample.normal, hard.origin, middles[light].position, offsets[light]));
        }
        put(middles.size(), open_share(*oracle_, camera_, sample, segments, radius));
      }
    });
    return shares;
  }

  scenes::ScenePtr scene_;
  PictureSize size_;
  gpu::SurfaceProbe probe_;
  std::unique_ptr<gpu::ReferenceView> view_;
  std::unique_ptr<test::EmbreeOracle> oracle_;
  gpu::CameraView camera_, before_;
  float exposure_ = 1;
  gpu::ProbedFrame newest_;  // that was drawn last
  protocol::FrameEncoder encoder_;
};

std::string label_of(const Drawn& drawn) {
  std::string label = drawn.name;
  char figures[64];
  if (drawn.trace_ms && drawn.bytes_referring) {
    std::snprintf(figures, sizeof figures, "  %.2f ms  %.1f kB", *drawn.trace_ms,
                  static_cast<double>(*drawn.bytes_referring) / 1e3);
    label += figures;
  }
  return label;
}

// Rows of pictures of one size, `columns` in each.
Picture tiled(const std::vector<Picture>& pictures, uint32_t columns) {
  const uint32_t width = pictures[0].width, height = pictures[0].height;
  const auto rows = static_cast<uint32_t>((pictures.size() + columns - 1) / columns);
  Picture whole(columns * width, rows * height);
  for (size_t i = 0; i < pictures.size(); ++i) {
    const auto left = static_cast<uint32_t>(i % columns) * width, top = static_cast<uint32_t>(i / columns) * height;
    for (uint32_t y = 0; y < height; ++y)
      std::copy_n(pictures[i].pixel(0, y), size_t{4} * width, whole.pixel(left, top + y));
  }
  return whole;
}

class SoftPicturesSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file whose lights have an extent")
        ->capture_default_str();
    command.add_option("--size", size_text_, "of each picture")->capture_default_str();
    command.add_option("--at", at_, "place on the scene's path, 0 to 1")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--tracer", tracer_, "tracer to measure")->capture_default_str();
    command.add_option("--repeats", repeats_, "of each frame; medians are reported")->capture_default_str();
    command.add_option("--pictures", folder_, "folder for the pictures, and for one of all of them");
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    report_.suite = "soft_pictures";
    for (const std::string& name : scenes_) {
      say("scene " + name);
      if (auto done = draw(name, *size); !done) return done.error();
    }
    if (folder_.empty()) return std::move(report_);
    if (auto written = client::write_png(folder_ / "all.png", tiled(labelled_, 5)); !written)
      return written.error();
    return std::move(report_);
  }

 private:
  Result<void> draw(const std::string& name, PictureSize size) {
    const auto scene = open_scene(name);
    if (!scene) return scene.error();
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = tracer_;
    auto view = View::create(options, *scene, at_ * path_seconds(**scene), size);
    if (!view) return view.error();
    report_.device = view->device().info().name;
    report_.driver = view->device().info().driver;
    std::vector<Drawn> all;
    for (const Kind& kind : kKinds) {
      auto drawn = view->draw(kind, std::max(1u, repeats_));
      if (!drawn) return drawn.error();
      all.push_back(std::move(*drawn));
    }
    auto reference = view->draw_reference(kKinds.back().samples);
    if (!reference) return reference.error();
    all.push_back(std::move(*reference));
    add_rows(name, all);
    const Picture apart = client::difference(all[kKinds.size() - 1].picture, all.back().picture, kGain);
    all.push_back({"difference of the two, times " + std::to_string(kGain), apart});
    return keep(name, all);
  }

  void add_rows(const std::string& scene, const std::vector<Drawn>& all) {
    for (const Drawn& drawn : all) {
      ordered_json row{{"scene", scene}, {"size", size_text_}, {"tracer", tracer_}, {"picture", drawn.name}};
      row["trace_ms"] = drawn.trace_ms ? ordered_json(*drawn.trace_ms) : ordered_json();
      row["bytes"] = drawn.bytes ? ordered_json(*drawn.bytes) : ordered_json();
      row["bytes_referring"] = drawn.bytes_referring ? ordered_json(*drawn.bytes_referring) : ordered_json();
      row["picture_rmse"] = rmse(drawn.picture, all.back().picture);
      report_.rows.push_back(std::move(row));
    }
  }

  Result<void> keep(const std::string& scene, const std::vector<Drawn>& all) {
    if (folder_.empty()) return {};
    std::error_code ignored;
    std::filesystem::create_directories(folder_, ignored);
    for (size_t i = 0; i < all.size(); ++i) {
      const auto file = folder_ / (scene + "-" + std::to_string(i + 1) + ".png");
      if (auto written = client::write_png(file, all[i].picture); !written) return written;
      Picture labelled = all[i].picture;
      client::write_label(labelled, 0, 0, labelled.width, label_of(all[i]), 2);
      labelled_.push_back(std::move(labelled));
    }
    return {};
  }

  std::vector<std::string> scenes_{"living_room", "temple"};
  std::string size_text_ = "480x270", device_, tracer_ = "light_buffer";
  double at_ = 0.5;
  uint32_t repeats_ = 3;
  std::filesystem::path folder_;
  std::vector<Picture> labelled_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_soft_pictures_suite() { return std::make_unique<SoftPicturesSuite>(); }

}  // namespace gnomon::bench
