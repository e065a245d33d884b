// Writes what the browser's renderer is held to: a scene pack, and for some cameras the masks that a server traces and
// the pictures that the reference client shades.
//
//   web_draw_inputs SCENE.glb FOLDER WIDTH HEIGHT [AT_MS]
//
// FOLDER gets scene.pack, views.json and, of view I: I.words, I.rgba (fresh), I.predicted.rgba (of a camera a few steps
// later) and I.smooth.rgba (with four samples a pixel), each also as PNG, I.ids (1 + the number of each pixel's
// triangle), I.light.L.rgba (base colours where light L shines) and I.later.words (traced for that later camera; `outcome`
// in views.json is the share of them that was predicted wrongly). I.soft.words and I.soft.rgba count kSoft: points of
// each area light, which `areas` in views.json names, and I.soft.predicted.rgba of the later camera. 0.soft.filtered.rgba,
// 0.soft.filtered.predicted.rgba and 0.soft.filtered.smooth.rgba are filtered. 0.half.words counts kHalf, and there are the
// same pictures of it. 0.shifted.J.words counts kShifted, with the camera of `shifted` in views.json: that of view 0, with
// the picture shifted by kShifts[J] pixels.
//
// AT_MS: the scene time; posed.positions and posed.normals are the vertices that move, `posed_lights` in views.json the
// lights at their places.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/media/camera_path.h"
#include "client/media/png.h"
#include "client/prediction/prediction_error.h"
#include "gpu/picture/reference_view.h"
#include "gpu/wire/translate.h"
#include "scenes/geometry/geometry.h"
#include "scenes/loader.h"
#include "scenes/motion.h"
#include "scenes/web_pack.h"
#include "scenes/world_mesh.h"
#include "tests/unit/gpu/surface_probe.h"
#include "tests/web/json_of.h"

namespace gnomon {
namespace {

constexpr uint32_t kViews = 3;
constexpr SampleCounts kSoft{16, Occlusion::full};
constexpr SampleCounts kHalf{4, Occlusion::half};
constexpr SampleCounts kShifted{4, Occlusion::full};
constexpr glm::ivec2 kShifts[] = {{0, 0}, {1, 0}, {2, 1}, {3, 2}};
constexpr uint32_t kTrialStep = 4;    // as web/render/outcome.js
constexpr double kStepSeconds = 0.1;  // from the camera of the masks to the one that is predicted

template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  std::cerr << "web_draw_inputs: " << result.error().message << "\n";
  std::exit(1);
}

// Masks are the same by every tracer; this one has nothing to build for long.
gpu::RendererOptions traced_quickly() {
  gpu::RendererOptions options;
  options.tracer = "bvh";
  return options;
}

class Inputs {
 public:
  Inputs(const std::filesystem::path& file, std::filesystem::path folder, client::ViewSize size,
         scenes::SceneTime time)
      : folder_(std::move(folder)),
        size_(size),
        time_(time),
        scene_(must(scenes::load_scene(file))),
        probe_(must(gpu::SurfaceProbe::create(traced_quickly(), scene_))),
        view_(must(gpu::ReferenceView::create({}, scene_))) {
    std::filesystem::create_directories(folder_);
    const auto served = must(scenes::load_with_geometry(file, {}, {}, scenes::Colours::encoded));
    write("scene.pack", must(scenes::web_pack(*served)));
    const auto geometry = scenes::geometry_of(*scene_);
    const auto& numbers = geometry->clusters.numbers;
    drawn_as_.resize(numbers.size());
    for (uint32_t t = 0; t < numbers.size(); ++t) drawn_as_[numbers[t]] = t;
  }

  void write_all() {
    const auto path = client::CameraPath::of_scene(scene_);
    nlohmann::json views;
    for (uint32_t i = 0; i < kViews; ++i) {
      const double seconds = path.duration_seconds() * i / kViews;
      views.push_back(view(i, client::view_of(path.at(seconds), size_),
                           client::view_of(path.at(seconds + kStepSeconds), size_)));
    }
    const auto posed = scenes::build_moving_mesh(*scene_, time_);
    write("posed.positions", posed.positions);
    write("posed.normals", posed.normals);
    const auto posed_lights = scenes::lights_at(*scene_, scene_->lights, time_);
    nlohmann::json lights, moved_lights, areas;
    for (const auto& light : scene_->lights) areas.push_back(light.area.shape != scenes::LightShape::point);
    for (const auto& light : gpu::to_wire(scene_->lights)) lights.push_back(json_of(light));
    for (const auto& light : gpu::to_wire(posed_lights)) moved_lights.push_back(json_of(light));
    std::ofstream(folder_ / "views.json") << nlohmann::json{
        {"width", size_.width},
        {"height", size_.height},
        {"scene_time_us", time_.count()},
        {"lights", lights},
        {"posed_lights", moved_lights},
        {"areas", areas},
        {"soft_samples", to_byte(kSoft)},
        {"half_samples", to_byte(kHalf)},
        {"shifted_samples", to_byte(kShifted)},
        {"shifted", shifted(client::view_of(path.at(0), size_))},
        {"views", views}}.dump(1);
  }

 private:
  template <class T>
  void write(const std::string& name, const std::vector<T>& data) {
    std::ofstream file(folder_ / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(T)));
  }
  void write(const std::string& name, const gpu::RgbaImage& image) {
    write(name + ".rgba", image.rgba);
    client::Picture picture(image.width, image.height);
    picture.rgba = image.rgba;
    if (const auto written = client::write_png(folder_ / (name + ".png"), picture); !written)
      std::cerr << written.error().message << "\n";
  }

  nlohmann::json view(uint32_t number, const protocol::CameraView& traced, const protocol::CameraView& later) {
    const std::string name = std::to_string(number);
    const gpu::CameraView camera = gpu::from_wire(traced);
    const auto frame = must(probe_.render(camera, size_.width, size_.height, time_));
    write(name + ".words", frame.words);
    std::vector<uint32_t> ids;
    for (const auto& sample : frame.samples)
      ids.push_back(sample.triangle == 0                  ? 0
                    : sample.triangle <= drawn_as_.size() ? drawn_as_[sample.triangle - 1] + 1
                                                          : sample.triangle);
    write(name + ".ids", ids);
    gpu::ShadeOptions options;
    options.time = time_;
    options.exposure = must(view_->suggest_exposure(camera));
    write(name, must(view_->render(camera, size_.width, size_.height, frame.mask(), options)));
    const auto seen = must(must(view_->reprojection())->see(camera, frame.mask(), time_));
    write(name + ".predicted",
          must(view_->predict(gpu::from_wire(later), size_.width, size_.height, seen, options)));
    const double outcome = outcome_of(name, later, seen, frame.mask());
    write_counted(name + ".soft", kSoft, camera, gpu::from_wire(later), options);
    if (number == 0) write_counted(name + ".half", kHalf, camera, gpu::from_wire(later), options);
    options.samples = gpu::Samples::four;
    write(name + ".smooth", must(view_->predict(camera, size_.width, size_.height, seen, options)));
    options.view = gpu::ShadeOptions::View::material;
    for (uint32_t light = 0; light < scene_->lights.size(); ++light) {
      options.only_light = light;
      write(name + ".light." + std::to_string(light) + ".rgba",
            must(view_->render(camera, size_.width, size_.height, frame.mask(), options)).rgba);
    }
    return {{"camera", json_of(traced)},
            {"predicted", json_of(later)},
            {"exposure", options.exposure},
            {"outcome", outcome}};
  }

  void write_counted(const std::string& name, SampleCounts counts, const gpu::CameraView& camera,
                     const gpu::CameraView& later, gpu::ShadeOptions options) {
    std::vector<bool> areas;
    for (const auto& light : scene_->lights) areas.push_back(light.area.shape != scenes::LightShape::point);
    options.planes = LightPlanes(areas, counts);
    const auto frame = must(probe_.render(camera, size_.width, size_.height, time_, counts));
    write(name + ".words", frame.words);
    const auto seen = must(must(view_->reprojection())->see(camera, frame.mask(), time_, options.planes));
    write_pictures(name, camera, later, frame.mask(), seen, options);
    if (!name.starts_with("0.")) return;
    options.soft_filter = true;
    write_pictures(name + ".filtered", camera, later, frame.mask(), seen, options);
    options.samples = gpu::Samples::four;
    write(name + ".filtered.smooth", must(view_->predict(camera, size_.width, size_.height, seen, options)));
  }

  nlohmann::json shifted(const protocol::CameraView& unshifted) {
    nlohmann::json cameras;
    const float pixel = (unshifted.tan_left + unshifted.tan_right) / static_cast<float>(size_.width);
    for (const auto& shift : kShifts) {
      protocol::CameraView camera = unshifted;
      camera.tan_left += pixel * static_cast<float>(shift.x);
      camera.tan_right -= pixel * static_cast<float>(shift.x);
      camera.tan_up += pixel * static_cast<float>(shift.y);
      camera.tan_down -= pixel * static_cast<float>(shift.y);
      const auto frame = must(probe_.render(gpu::from_wire(camera), size_.width, size_.height, time_, kShifted));
      write("0.shifted." + std::to_string(cameras.size()) + ".words", frame.words);
      cameras.push_back(json_of(camera));
    }
    return cameras;
  }

  void write_pictures(const std::string& name, const gpu::CameraView& camera, const gpu::CameraView& later,
                      const TileMaskView& mask, const gpu::SeenMasks& seen, const gpu::ShadeOptions& options) {
    write(name, must(view_->render(camera, size_.width, size_.height, mask, options)));
    write(name + ".predicted", must(view_->predict(later, size_.width, size_.height, seen, options)));
  }

  // As client::ClientRenderer::outcome.
  double outcome_of(const std::string& name, const protocol::CameraView& later, const gpu::SeenMasks& seen,
                    const TileMaskView& masks) {
    const gpu::CameraView camera = gpu::from_wire(later);
    const auto fresh = must(probe_.render(camera, size_.width, size_.height, time_));
    write(name + ".later.words", fresh.words);
    gpu::Reprojection& reprojection = *must(view_->reprojection());
    const auto raster = must(reprojection.rasterise(camera, size_.width, size_.height, time_));
    const auto sources = must(reprojection.sources(raster, seen.raster));
    return client::compare_some(masks, sources, fresh.mask(), {0, 0, size_.width, size_.height}, kTrialStep)
        .share();
  }

  std::filesystem::path folder_;
  client::ViewSize size_;
  scenes::SceneTime time_;
  scenes::ScenePtr scene_;
  gpu::SurfaceProbe probe_;
  std::unique_ptr<gpu::ReferenceView> view_;
  std::vector<uint32_t> drawn_as_;  // for each triangle of build_world_mesh: its number in the order of drawing
};

}  // namespace
}  // namespace gnomon

int main(int argc, char** argv) {
  if (argc < 5) {
    std::cerr << "usage: web_draw_inputs SCENE.glb FOLDER WIDTH HEIGHT [AT_MS]\n";
    return 2;
  }
  const auto number = [](const char* text) { return static_cast<uint32_t>(std::strtoul(text, nullptr, 10)); };
  const std::chrono::milliseconds at(argc > 5 ? number(argv[5]) : 0);
  gnomon::Inputs(argv[1], argv[2], {number(argv[3]), number(argv[4])}, at).write_all();
}
