// Flies a scene's camera path with the native client's prediction, without a network: each third camera's masks arrive
// four cameras late. Writes what it was given and what it showed, for the page to fly the same (flight_checks.mjs).
//
//   web_flight_inputs SCENE.glb FOLDER WIDTH HEIGHT CAMERAS
//
// FOLDER gets scene.pack, views.json (what checks.open() reads), N.words, the masks of camera N, and flight.json: cameras
// with the border, when masks arrive, and of each picture its camera, its masks' camera, the share of its pixels that have
// a source, and the share of their bits that is wrong.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "client/media/camera_path.h"
#include "client/prediction/error_balance.h"
#include "client/prediction/prediction_error.h"
#include "client/prediction/show_order.h"
#include "client/view/client_renderer.h"
#include "gpu/wire/translate.h"
#include "scenes/geometry/geometry.h"
#include "scenes/loader.h"
#include "scenes/web_pack.h"
#include "tests/unit/gpu/surface_probe.h"
#include "tests/web/json_of.h"

namespace gnomon {
namespace {

constexpr std::chrono::microseconds kStep(16667);
constexpr uint32_t kEach = 3, kLate = 4;  // masks: of each third camera, four cameras later
constexpr uint32_t kStepsAhead = 4;       // pictures by which the border goes before the turn, as web/viewer.js
constexpr uint32_t kSparse = 4;           // pixels that are looked at, as web/render/outcome.js

template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  std::cerr << "web_flight_inputs: " << result.error().message << "\n";
  std::exit(1);
}

template <class T>
void write(const std::filesystem::path& file, const std::vector<T>& data) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(T)));
}

gpu::RendererOptions traced_quickly() {
  gpu::RendererOptions options;
  options.tracer = "bvh";
  return options;
}

class Flight {
 public:
  Flight(const std::filesystem::path& scene, std::filesystem::path folder, client::ViewSize size)
      : folder_(std::move(folder)),
        size_(size),
        scene_(must(scenes::load_scene(scene))),
        probe_(must(gpu::SurfaceProbe::create(traced_quickly(), scene_))),
        view_(must(gpu::ReferenceView::create({}, scene_))),
        renderer_(must(client::ClientRenderer::create(scene_, size_, {}))) {
    std::filesystem::create_directories(folder_);
    write(folder_ / "scene.pack",
          must(scenes::web_pack(*must(scenes::load_with_geometry(scene, {}, {}, scenes::Colours::encoded)))));
  }

  void fly(uint32_t cameras) {
    trace(cameras);
    client::ShowOrder order(client::Mode::automatic,
                            std::make_unique<client::ErrorBalance>(client::ErrorBalanceOptions{.size = size_}));
    nlohmann::json shown = nlohmann::json::array(), asked = nlohmann::json::array();
    for (uint32_t n = 0; n < cameras; ++n) {
      const TimePoint now = TimePoint{} + n * kStep;
      order.asked(masks_[n]->camera, now);
      asked.push_back(json_of(masks_[n]->camera));
      if (n >= kLate && (n - kLate) % kEach == 0) order.answered(n - kLate, now);
      if (const auto next = order.next(now)) shown.push_back(show(n, *next, order));
    }
    nlohmann::json lights;
    for (const auto& light : gpu::to_wire(scene_->lights)) lights.push_back(json_of(light));
    const nlohmann::json size{
        {"width", size_.width}, {"height", size_.height}, {"borderX", size_.border_x}, {"borderY", size_.border_y}};
    const double step_ms = std::chrono::duration<double, std::milli>(kStep).count();
    std::ofstream(folder_ / "views.json") << nlohmann::json{{"lights", lights}}.dump();
    std::ofstream(folder_ / "flight.json") << nlohmann::json{{"size", size},  {"stepMs", step_ms}, {"each", kEach},
                                                             {"late", kLate}, {"cameras", asked},  {"shown", shown}}
                                                  .dump(1);
  }

 private:
  // What a server would send for each camera of the path.
  void trace(uint32_t cameras) {
    const auto path = client::CameraPath::of_scene(scene_);
    for (uint32_t n = 0; n < cameras; ++n) {
      const double seconds = n * std::chrono::duration<double>(kStep).count();
      const auto now = path.at(seconds);
      const auto before = path.at(seconds - std::chrono::duration<double>(kStep).count());
      auto masks = std::make_shared<client::ReceivedMasks>();
      masks->index = n;
      masks->camera =
          client::view_of(now, size_, client::towards(size_, now, client::extrapolate(before, now, kStepsAhead)));
      auto frame = must(probe_.render(gpu::from_wire(masks->camera), size_.traced_width(), size_.traced_height()));
      masks->mask.grid = frame.grid;
      masks->mask.words = std::move(frame.words);
      masks->mask.arrived.assign(masks->mask.words.size(), true);
      write(folder_ / (std::to_string(n) + ".words"), masks->mask.words);
      masks_.push_back(std::move(masks));
    }
  }

  nlohmann::json show(uint32_t tick, const client::Shown& shown, client::ShowOrder& order) {
    const auto& seen = masks_[shown.seen.index];
    const client::Showing showing{.index = shown.camera.index,
                                  .newest = shown.newest,
                                  .camera = shown.camera.camera,
                                  .seen = seen,
                                  .reprojected = shown.reprojected};
    if (const auto outcome = must(renderer_.outcome(showing)))
      order.ahead().observe(outcome->earlier, outcome->later, outcome->error);
    const auto [known, wrong] = prediction(*seen, *masks_[shown.camera.index]);
    return {
        {"tick", tick}, {"camera", shown.camera.index}, {"seen", seen->index}, {"known", known}, {"wrong", wrong}};
  }

  // Shares of the pixels of the later picture that have a source, and of their bits that are wrong.
  std::pair<double, double> prediction(const client::ReceivedMasks& seen, const client::ReceivedMasks& later) {
    gpu::Reprojection& reprojection = *must(view_->reprojection());
    const auto from = must(reprojection.see(gpu::from_wire(seen.camera), seen.mask.mask(), {}));
    const auto raster = must(reprojection.rasterise(gpu::from_wire(client::shown_part(later.camera, size_)),
                                                    size_.width, size_.height, {}));
    const auto sources = must(reprojection.sources(raster, from.raster));
    uint32_t pixels = 0, known = 0;
    for (uint32_t y = 0; y < size_.height; y += kSparse) {
      for (uint32_t x = 0; x < size_.width; x += kSparse, ++pixels) known += sources[y * size_.width + x] != 0;
    }
    const auto place = client::place_of(later.camera, size_);
    const auto error = client::compare_some(seen.mask.mask(), sources, later.mask.mask(),
                                            {place.left, place.top, size_.width, size_.height}, kSparse);
    return {static_cast<double>(known) / pixels, error.share()};
  }

  std::filesystem::path folder_;
  client::ViewSize size_;
  scenes::ScenePtr scene_;
  gpu::SurfaceProbe probe_;
  std::unique_ptr<gpu::ReferenceView> view_;
  client::ClientRenderer renderer_;
  std::vector<std::shared_ptr<const client::ReceivedMasks>> masks_;
};

}  // namespace
}  // namespace gnomon

int main(int argc, char** argv) {
  if (argc != 6) {
    std::cerr << "usage: web_flight_inputs SCENE.glb FOLDER WIDTH HEIGHT CAMERAS\n";
    return 2;
  }
  const auto number = [](const char* text) { return static_cast<uint32_t>(std::strtoul(text, nullptr, 10)); };
  constexpr uint32_t kBorder = 16;
  gnomon::Flight(argv[1], argv[2], {number(argv[3]), number(argv[4]), kBorder, kBorder}).fly(number(argv[5]));
}
