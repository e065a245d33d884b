// Suite "motion": instances of a scene turn where they stand. What tracing them takes in each frame, beside the hard shadows
// of what rests in the same frames, and what posing them takes of a processor for each step of the scene's clock.
#include <algorithm>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

#include "common/clock.h"
#include "gpu/scene/resident_scene.h"
#include "scenes/content_hash.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/steady_times.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

constexpr float kTurnSeconds = 4.0f;
constexpr uint32_t kClockHz = 60;  // as scenes.clock_hz
// What moves is furniture and people, not walls: no instance has more of the scene's triangles than one in so many.
constexpr uint64_t kLargestPart = 20;

uint64_t triangles_of(const scenes::Mesh& mesh) {
  uint64_t count = 0;
  for (const scenes::Primitive& primitive : mesh.primitives) count += primitive.triangles.size();
  return count;
}

// The instances to move: those of the most triangles that are no large part of the scene.
std::vector<size_t> to_move(const scenes::Scene& scene, size_t wanted) {
  const auto size = [&](size_t i) { return triangles_of(scene.meshes[scene.instances[i].mesh]); };
  std::vector<size_t> chosen(scene.instances.size());
  std::iota(chosen.begin(), chosen.end(), size_t{0});
  std::erase_if(chosen, [&](size_t i) { return size(i) == 0 || size(i) * kLargestPart > scene.triangle_count; });
  std::ranges::stable_sort(chosen, [&](size_t a, size_t b) { return size(a) > size(b); });
  chosen.resize(std::min(chosen.size(), wanted));
  return chosen;
}

glm::vec3 middle_of(const scenes::Scene& scene, const scenes::Instance& instance) {
  glm::vec3 lo(std::numeric_limits<float>::infinity()), hi(-lo);
  for (const scenes::Primitive& primitive : scene.meshes[instance.mesh].primitives)
    for (const glm::vec3& position : primitive.positions) {
      const glm::vec3 p(instance.object_to_world * glm::vec4(position, 1.0f));
      lo = glm::min(lo, p);
      hi = glm::max(hi, p);
    }
  return 0.5f * lo + 0.5f * hi;
}

// Makes the instance turn about the upright axis through its middle.
void let_turn(scenes::Scene& scene, scenes::Instance& instance) {
  const glm::vec3 middle = middle_of(scene, instance);
  scenes::MovingNode turning;
  turning.parent_to_world = glm::translate(glm::dmat4(1.0), glm::dvec3(middle));
  scenes::Channel& channel = turning.channels.emplace_back();
  channel.path = scenes::Channel::Path::rotation;
  for (int key = 0; key <= 4; ++key) {
    const glm::quat turned = glm::angleAxis(static_cast<float>(key) * glm::half_pi<float>(), glm::vec3(0, 1, 0));
    channel.times.push_back(static_cast<float>(key) * kTurnSeconds / 4);
    channel.values.emplace_back(turned.x, turned.y, turned.z, turned.w);
  }
  scenes::MovingNode shape;
  shape.parent = static_cast<uint32_t>(scene.moving_nodes.size());
  shape.local.has_matrix = true;
  shape.local.matrix = glm::translate(glm::mat4(1.0f), -middle) * instance.object_to_world;
  instance.moved_by = shape.parent + 1;
  scene.moving_nodes.push_back(std::move(turning));
  scene.moving_nodes.push_back(std::move(shape));
}

std::shared_ptr<scenes::Scene> with_turning(const scenes::Scene& scene, const std::vector<size_t>& instances) {
  auto made = std::make_shared<scenes::Scene>(scene);
  made->geometry.reset();
  for (const size_t i : instances) let_turn(*made, made->instances[i]);
  made->period = std::chrono::microseconds(std::lround(1e6f * kTurnSeconds));
  const scenes::Extent extent = scenes::measure(*made);
  made->bounds = extent.bounds;
  made->content_hash = extent.hash;
  return made;
}

class MotionSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file; default: all that are there");
    command.add_option("--size", size_text_, "pixels of the picture")->capture_default_str();
    command.add_option("--device", device_, "index, type or part of the name");
    command.add_option("--tracer", tracer_, "of what rests")->capture_default_str();
    command.add_option("--frames", frames_, "cameras along the scene's path")->capture_default_str();
    command.add_option("--instances", instances_, "how many of the scene's instances move")->capture_default_str();
    command.add_option("--poses", poses_, "steps of the clock whose posing is timed")->capture_default_str();
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    report_.suite = "motion";
    if (scenes_.empty()) scenes_ = default_scenes();
    for (const std::string& name : scenes_) {
      const auto scene = open_scene(name);
      if (!scene) return scene.error();
      const std::vector<size_t> moving = to_move(**scene, instances_);
      if (moving.empty()) {
        say("scene " + name + ": skipped, every instance is a large part of it");
        continue;
      }
      say("scene " + name);
      if (auto measured = measure(with_turning(**scene, moving), moving.size(), *size); !measured)
        return measured.error();
    }
    return std::move(report_);
  }

 private:
  Result<void> measure(const scenes::ScenePtr& scene, size_t instances, PictureSize size) {
    gpu::RendererOptions options;
    options.device = device_;
    options.tracer = tracer_;
    auto frame = gpu::BlockingFrame::create(options, options.passes, scene);
    if (!frame) return frame.error();
    report_.device = (*frame)->device().info().name;
    report_.driver = (*frame)->device().info().driver;
    std::vector<double> resting_ms, moving_ms, share, frame_ms;
    const std::vector<gpu::CameraView> cameras = cameras_along_path(*scene, std::max(1u, frames_), size);
    for (size_t i = 0; i < cameras.size(); ++i) {
      const auto time = scene->period * static_cast<int64_t>(2 * i + 1) / static_cast<int64_t>(2 * cameras.size());
      const auto grid = (*frame)->reserve(size.width, size.height, time);
      if (!grid) return grid.error();
      // The first frame compiles shaders and is not counted.
      if (auto warm = (*frame)->render(cameras[i], *grid); i == 0 && !warm) return warm.error();
      const auto times = steady_times(**frame, cameras[i], *grid);
      if (!times) return times.error();
      resting_ms.push_back(times->shadow_stage_ms());
      moving_ms.push_back(times->stage_ms.at("trace_moving"));
      share.push_back(moving_ms.back() / resting_ms.back());
      frame_ms.push_back(times->frame_ms);
    }
    report_.rows.push_back({{"scene", scene->name},
                            {"instances", instances},
                            {"moving_triangles", (*frame)->scene().moving_size().triangles},
                            {"size", size_text_},
                            {"trace_ms", median(resting_ms)},
                            {"trace_moving_ms", median(moving_ms)},
                            {"moving_to_resting", median(share)},
                            {"frame_ms", median(frame_ms)},
                            {"pose_ms", median(posing_ms((*frame)->scene()))}});
    return {};
  }

  // What each step of the clock takes, on one thread.
  std::vector<double> posing_ms(const gpu::ResidentScene& scene) const {
    std::vector<double> ms;
    for (uint32_t step = 1; step <= std::max(1u, poses_); ++step) {
      const scenes::SceneTime time(uint64_t{1'000'000} * step / kClockHz);
      const TimePoint start = Clock::now();
      scene.pose(scenes::within_period(scene.scene(), time));
      ms.push_back(to_milliseconds(Clock::now() - start));
    }
    return ms;
  }

  std::vector<std::string> scenes_;
  std::string size_text_ = "1920x1080", device_, tracer_ = "auto";
  uint32_t frames_ = 5, instances_ = 3, poses_ = 240;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_motion_suite() { return std::make_unique<MotionSuite>(); }

}  // namespace gnomon::bench
