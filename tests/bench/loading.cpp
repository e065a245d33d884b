// Suite "loading": what reading a scene, and building what traces it, takes in a process of its own beside this process.
#include <algorithm>
#include <functional>

#include "common/clock.h"
#include "daemon/scenes/scene_worker.h"
#include "scenes/geometry/geometry.h"
#include "scenes/loader.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

using Work = std::function<Result<void>()>;

struct Times {
  std::vector<double> here_ms, worker_ms, ratios;
};

class LoadingSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", names_,
                       "scenes: built in, beside the repository, or files; default: all there are");
    command.add_option("--rounds", rounds_, "of each scene, in turns")->capture_default_str();
    command.add_option("--worker", worker_.program, "gnomon-scene-worker of another build")->capture_default_str();
  }

  Result<Report> run() override {
    report_.suite = "loading";
    if (names_.empty()) names_ = default_scenes();
    worker_.max_memory_bytes = uint64_t{16} << 30;
    for (const std::string& name : names_) {
      say("loading " + name);
      const auto file = scene_file(name);
      if (!file) return file.error();
      if (auto measured = measure(name, *file); !measured) return measured.error();
    }
    return std::move(report_);
  }

 private:
  Result<void> measure(const std::string& name, const std::filesystem::path& file) {
    const scenes::SceneSource source{name, file};
    scenes::ScenePtr scene;
    const auto keep = [&](Result<scenes::ScenePtr> read) -> Result<void> {
      if (!read) return read.error();
      scene = std::move(*read);
      return {};
    };
    const auto read = compare([&] { return keep(scenes::read_here(source, {})); },
                              [&] { return keep(daemon::load_in_worker(worker_, source, {})); });
    if (!read) return read.error();
    add_row(name, *scene, "read", *read);
    const scenes::GeometryPtr geometry = scenes::geometry_of(*scene);
    const auto hierarchy = compare([&] { return done(here_->bvh(geometry->mesh)); },
                                   [&] { return done(apart().bvh(geometry->mesh)); });
    if (!hierarchy) return hierarchy.error();
    add_row(name, *scene, "hierarchy", *hierarchy);
    return {};
  }

  template <class T>
  static Result<void> done(const Result<T>& result) {
    return result ? Result<void>() : Result<void>(result.error());
  }

  // In turns, so that what else the machine does meets both alike. One round before counts for none.
  Result<Times> compare(const Work& here, const Work& in_worker) const {
    Times times;
    for (uint32_t round = 0; round <= rounds_; ++round) {
      double ms[2] = {};
      for (const bool worker_first : {round % 2 == 0, round % 2 != 0}) {
        const TimePoint began = Clock::now();
        const auto worked = worker_first ? in_worker() : here();
        if (!worked) return worked.error();
        ms[worker_first] = to_milliseconds(Clock::now() - began);
      }
      if (round == 0) continue;
      times.here_ms.push_back(ms[0]);
      times.worker_ms.push_back(ms[1]);
      times.ratios.push_back(ms[1] / ms[0]);
    }
    return times;
  }

  void add_row(const std::string& name, const scenes::Scene& scene, const char* work, const Times& times) {
    const auto [least, most] = std::minmax_element(times.ratios.begin(), times.ratios.end());
    report_.rows.push_back({{"scene", std::filesystem::path(name).stem().string()},
                            {"triangles", scene.triangle_count},
                            {"work", work},
                            {"here_ms", median(times.here_ms)},
                            {"worker_ms", median(times.worker_ms)},
                            {"ratio", median(times.ratios)},
                            {"ratio_least", *least},
                            {"ratio_most", *most}});
  }

  const gpu::StructureBuilds& apart() {
    if (!in_worker_) in_worker_ = daemon::builds_in_worker(worker_);
    return *in_worker_;
  }

  std::vector<std::string> names_;
  uint32_t rounds_ = 9;
  daemon::SceneWorkerOptions worker_{.program = GNOMON_SCENE_WORKER};
  gpu::StructureBuildsPtr here_ = gpu::builds_here(), in_worker_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_loading_suite() { return std::make_unique<LoadingSuite>(); }

}  // namespace gnomon::bench
