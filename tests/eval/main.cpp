// gnomon-eval: what tests/eval/run measures without a network. Writes CSV.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "client/cli/options.h"
#include "client/prediction/error_balance.h"
#include "client/prediction/switching.h"
#include "common/progress.h"
#include "tests/bench/bench_scenes.h"
#include "tests/eval/auto_link.h"
#include "tests/eval/path_errors.h"
#include "tests/eval/path_pictures.h"

namespace {

using namespace gnomon;
using namespace gnomon::eval;

struct Arguments {
  std::string scene, size = "480x270", device, out, errors, cache, border = "128x72";
  double fps = 60, seconds = 0, from = 0;
  uint32_t stride = 1, x = 4, seed = 1;
  std::vector<uint32_t> every_x;
};

std::string name_of(const Arguments& a) { return std::filesystem::path(a.scene).stem().string(); }

Result<PathPlan> plan_of(const Arguments& a, const scenes::ScenePtr& scene) {
  const auto size = client::parse_size(a.size);
  if (!size) return size.error();
  const double seconds = a.seconds > 0 ? a.seconds : bench::path_seconds(*scene);
  const Border widest = borders_of(size->width, size->height).back();
  PathPlan plan;
  plan.size = {size->width, size->height, widest.x, widest.y};
  plan.fps = a.fps;
  plan.first = static_cast<uint32_t>(a.from * a.fps);
  plan.count = static_cast<uint32_t>(seconds * a.fps);
  plan.stride = a.stride;
  plan.device = a.device;
  plan.cache = a.cache;
  return plan;
}

Result<void> write(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) return Error{"cannot write " + file};
  return {};
}

// Mean error for each border and x; and each frame's, for `auto`.
Result<void> run_errors(const Arguments& a) {
  const auto scene = bench::open_scene(a.scene);
  if (!scene) return scene.error();
  const auto plan = plan_of(a, *scene);
  if (!plan) return plan.error();
  Progress progress;
  const auto errors = measure_path(*scene, *plan, [&](uint32_t done) {
    const TimePoint now = Clock::now();
    if (progress.due(now))
      progress.show(
          std::string("  ") + name_of(a) + ": frame " + std::to_string(done) + " of " + std::to_string(plan->count),
          now);
  });
  if (!errors) return errors.error();
  std::ostringstream means, frames;
  means
      << "scene,size,border,x,error_per_light,error_share,error_share_of_picture,falsely_dark_share,frames,lights,"
         "device,driver\n";
  const size_t predicted = (plan->count + plan->stride - 1) / plan->stride;
  for (size_t b = 0; b < errors->borders.size(); ++b)
    for (size_t x = 1; x <= kMostAhead; ++x) {
      const auto& sum = errors->sums[b][x - 1];
      const auto count = static_cast<double>(sum.pixels) / (plan->size.width * plan->size.height);
      means << name_of(a) << ',' << a.size << ',' << errors->borders[b].name << ',' << x << ','
            << sum.per_light(errors->lights) / std::max(1.0, count) << ',' << sum.share() << ','
            << sum.share_of_picture(errors->lights) << ','
            << (sum.bits ? static_cast<double>(sum.falsely_dark) / static_cast<double>(sum.bits) : 0) << ','
            << predicted << ',' << errors->lights << ",\"" << errors->device << "\",\"" << errors->driver << "\"\n";
    }
  for (const auto& row : errors->frames) {
    for (size_t x = 0; x < row.size(); ++x) frames << (x ? "," : "") << row[x];
    frames << '\n';
  }
  if (auto written = write(a.out, means.str()); !written) return written;
  return write(a.out + ".frames", frames.str());
}

Result<std::vector<std::vector<double>>> read_frames(const std::string& file) {
  std::ifstream in(file);
  if (!in) return Error{"cannot read " + file};
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

// Frames that were not measured are as those before them.
void fill(std::vector<std::vector<double>>& frames) {
  for (size_t i = 1; i < frames.size(); ++i)
    for (size_t x = 0; x < frames[i].size(); ++x)
      if (frames[i][x] < 0) frames[i][x] = std::max(0.0, frames[i - 1][x]);
}

void add(std::ostringstream& out, const Arguments& a, const std::string& policy, double parameter,
         const Outcome& o) {
  out << name_of(a) << ',' << policy << ',' << parameter << ',' << o.error << ',' << o.response_ms << ','
      << o.mean_x << '\n';
}

// Every fixed x, the dissertation's switching over many thresholds, and ours over what time costs.
Result<void> run_auto(const Arguments& a) {
  const auto scene = bench::open_scene(a.scene);
  if (!scene) return scene.error();
  auto frames = read_frames(a.errors);
  if (!frames) return frames.error();
  fill(*frames);
  const auto size = client::parse_size(a.size);
  if (!size) return size.error();
  LinkPlan plan;
  plan.scene = *scene;
  for (const Border& border : borders_of(size->width, size->height))
    if (border.name == kKeptBorder) plan.size = {size->width, size->height, border.x, border.y};
  plan.fps = a.fps;
  plan.first = static_cast<uint32_t>(a.from * a.fps);
  plan.errors = &*frames;
  plan.seed = a.seed;
  plan.round_trips_ms = {10, 60, 230, 35, 120, 170, 20, 90, 200, 5, 150, 45, 75};
  std::shuffle(plan.round_trips_ms.begin(), plan.round_trips_ms.end(), std::mt19937(a.seed));
  plan.phase_s = static_cast<double>(frames->size()) / a.fps / static_cast<double>(plan.round_trips_ms.size());
  std::ostringstream out;
  out << "scene,policy,parameter,error_share,response_ms,mean_x\n";
  for (size_t x = 0; x <= kMostAhead; ++x)
    add(out, a, "fixed", static_cast<double>(x), play(plan, std::make_unique<client::FixedPrediction>(x)));
  for (const double high : {0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.12, 0.2})
    for (const uint32_t dwell : {5u, 30u, 60u}) {
      client::SwitchingOptions options;
      options.high = high;
      options.mid = high * 2 / 3;
      options.low = high / 3;
      options.dwell = dwell;
      add(out, a, "switching dwell " + std::to_string(dwell), high,
          play(plan, std::make_unique<client::Switching>(options)));
    }
  for (double cost = 0.005; cost < 4; cost *= 1.02)
    add(out, a, "auto", cost,
        play(plan, std::make_unique<client::ErrorBalance>(
                       client::ErrorBalanceOptions{.size = plan.size, .cost_per_s = cost})));
  return write(a.out, out.str());
}

// With the border that was asked for.
Result<PathPlan> bordered_plan(const Arguments& a, const scenes::ScenePtr& scene) {
  auto plan = plan_of(a, scene);
  if (!plan) return plan.error();
  for (const Border& border : borders_of(plan->size.width, plan->size.height)) {
    if (border.name != a.border) continue;
    plan->size.border_x = border.x;
    plan->size.border_y = border.y;
    return plan;
  }
  return Error{"no border is called '" + a.border + "'; there are 0, 64x36, 128x72, 640x360"};
}

Result<void> run_pictures(const Arguments& a) {
  const auto scene = bench::open_scene(a.scene);
  if (!scene) return scene.error();
  const auto plan = bordered_plan(a, *scene);
  if (!plan) return plan.error();
  PathPictures::Plan pictures{*scene, plan->size, a.fps, a.device, a.cache};
  auto made = PathPictures::create(pictures);
  if (!made) return made.error();
  const auto frame = static_cast<uint32_t>((a.from + a.seconds / 2) * a.fps);
  return made->write_example(frame, a.x, a.out);
}

// Raw RGB frames of the path, predicted x ahead (0: their own masks), to standard output.
Result<void> run_video(const Arguments& a) {
  const auto scene = bench::open_scene(a.scene);
  if (!scene) return scene.error();
  const auto plan = bordered_plan(a, *scene);
  if (!plan) return plan.error();
  auto made = PathPictures::create({*scene, plan->size, a.fps, a.device, a.cache});
  if (!made) return made.error();
  Progress progress;
  return made->write_videos(plan->first, plan->count, a.every_x, a.out, [&](uint32_t done) {
    const TimePoint now = Clock::now();
    if (progress.due(now))
      progress.show(
          std::string("  ") + name_of(a) + ": frame " + std::to_string(done) + " of " + std::to_string(plan->count),
          now);
  });
}

// Whom all of it is measured on.
Result<void> say_device(const Arguments& a) {
  const auto device = gpu::Device::create({a.device, {}});
  if (!device) return device.error();
  std::printf("%s, %s\n", (*device)->info().name.c_str(), (*device)->info().driver.c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What tests/eval/run measures without a network.", "gnomon-eval");
  app.require_subcommand(1);
  Arguments a;
  const auto common = [&](CLI::App* sub) {
    sub->add_option("--scene", a.scene, "a built-in's name, one beside the repository, or a file")->required();
    sub->add_option("--size", a.size, "of the picture")->type_name("WxH");
    sub->add_option("--fps", a.fps, "of the path");
    sub->add_option("--seconds", a.seconds, "of the path; 0: all of it");
    sub->add_option("--from", a.from, "seconds of the path that come before");
    sub->add_option("--device", a.device, "Vulkan device: name, index or type");
    sub->add_option("--cache", a.cache, "folder for light buffers, so that the next run is quick to start");
    sub->add_option("--border", a.border, "as at 1920x1080: 0, 64x36, 128x72 or 640x360");
    sub->add_option("--out", a.out, "file, or start of the files' names")->required();
    return sub;
  };
  auto* errors = common(app.add_subcommand("errors", "wrong bits for x = 1...19 and each border; FILE.frames too"));
  errors->add_option("--stride", a.stride, "predict every so many frames")->check(CLI::Range(1u, 10000u));
  auto* automatic = common(app.add_subcommand("auto", "policies for x on a link that changes, in virtual time"));
  automatic->add_option("--errors", a.errors, "the file FILE.frames of `errors`")->required();
  automatic->add_option("--seed", a.seed, "of the link");
  auto* pictures = common(app.add_subcommand("pictures", "predicted, fresh and difference: PNG"));
  pictures->add_option("--x", a.x, "frames predicted ahead");
  auto* video = common(app.add_subcommand("video", "the path's pictures for each x: PREFIX-x.rgb, raw RGB"));
  video->add_option("--x", a.every_x, "frames predicted ahead")->required();
  auto* device = app.add_subcommand("device", "the name of the device that the others would take, and its driver");
  device->add_option("--device", a.device, "Vulkan device: name, index or type");
  CLI11_PARSE(app, argc, argv);
  const auto done = errors->parsed()      ? run_errors(a)
                    : automatic->parsed() ? run_auto(a)
                    : pictures->parsed()  ? run_pictures(a)
                    : device->parsed()    ? say_device(a)
                                          : run_video(a);
  if (!done) std::fprintf(stderr, "gnomon-eval: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
