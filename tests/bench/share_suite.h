// What the suites "penumbra" and "occlusion" have in common: cameras along the paths of scenes, whose shares by a few
// segments are compared with a reference.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tests/bench/bench_scenes.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {

class ShareSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, scene_help_)->capture_default_str();
    command.add_option("--size", size_text_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
    command.add_option("--step", step_, "columns and rows from one pixel that is compared to the next")
        ->check(CLI::Range(1u, 64u))
        ->capture_default_str();
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    size_ = *size;
    frames_ = std::max(1u, frames_);
    for (const std::string& name : scenes_) {
      const auto scene = open_scene(name);
      if (!scene) return scene.error();
      if (auto measured = measure(*scene); !measured) return measured.error();
    }
    return std::move(report_);
  }

 protected:
  ShareSuite(std::string suite, std::string scene_help) : scene_help_(std::move(scene_help)) {
    report_.suite = std::move(suite);
  }

  virtual Result<void> measure(const scenes::ScenePtr& scene) = 0;  // adds its rows to report_

  bool compared(uint32_t x, uint32_t y) const { return x % step_ == 0 && y % step_ == 0; }
  // Of camera i of frames_.
  double seconds_of(const scenes::Scene& scene, uint32_t i) const {
    return path_seconds(scene) * (i + 0.5) / frames_;
  }

  std::string size_text_ = "480x270", device_;
  uint32_t frames_ = 3, step_ = 1;
  PictureSize size_;
  Report report_;

 private:
  std::vector<std::string> scenes_{"living_room", "temple"};
  std::string scene_help_;
};

}  // namespace gnomon::bench
