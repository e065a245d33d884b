#include "tests/bench/path_masks.h"

#include <cstring>
#include <fstream>

#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"
#include "gpu/wire/translate.h"
#include "tests/bench/report.h"

namespace gnomon::bench {
namespace {

// The name of a cached file: the scene and its content, the size, the number of spots and their ages.
std::string key_of(const std::string& name, const scenes::Scene& scene, const PathPlan& plan) {
  std::string key = std::filesystem::path(name).stem().string() + "-" + scenes::to_hex(scene.content_hash) + "-" +
                    std::to_string(plan.size.width) + "x" + std::to_string(plan.size.height) + "-" +
                    std::to_string(plan.spots);
  for (const uint32_t age : plan.ages_ms) key.append("-").append(std::to_string(age));
  return key;
}

void pack(PathFrame& frame, const TileGrid& grid) {
  frame.packed = PackedMask({grid, frame.words}, frame.valid_bits);
}

template <class Visit>
void for_each_frame(PathMasks& masks, const PathPlan& plan, Visit visit) {
  masks.spots.resize(plan.spots);
  for (PathSpot& spot : masks.spots) {
    spot.before.resize(plan.ages_ms.size());
    visit(spot.now);
    for (PathFrame& frame : spot.before) visit(frame);
  }
}

std::span<char> bytes_of(std::vector<uint64_t>& words) {
  return {reinterpret_cast<char*>(words.data()), words.size() * sizeof(uint64_t)};
}

// The cameras are computed again: only what is rendered is cached.
void place_cameras(const scenes::Scene& scene, const PathPlan& plan, PathMasks& masks) {
  for (uint32_t i = 0; i < plan.spots; ++i) {
    PathSpot& spot = masks.spots[i];
    const double seconds = path_seconds(scene) * (i + 0.5) / plan.spots;
    spot.now.camera = gpu::to_wire(camera_on_path(scene, seconds, plan.size));
    for (size_t age = 0; age < plan.ages_ms.size(); ++age)
      spot.before[age].camera = gpu::to_wire(camera_on_path(scene, seconds - plan.ages_ms[age] / 1e3, plan.size));
  }
}

bool read_kept(const std::filesystem::path& file, const PathPlan& plan, PathMasks& masks) {
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(&masks.grid), sizeof masks.grid)) return false;
  for_each_frame(masks, plan, [&](PathFrame& frame) {
    for (auto* words : {&frame.words, &frame.valid_bits}) {
      words->resize(masks.grid.word_count());
      in.read(bytes_of(*words).data(), static_cast<std::streamsize>(bytes_of(*words).size()));
    }
    if (in) pack(frame, masks.grid);
  });
  return in.good();
}

Result<void> keep(const std::filesystem::path& file, const PathPlan& plan, PathMasks& masks) {
  std::error_code ignored;
  std::filesystem::create_directories(file.parent_path(), ignored);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&masks.grid), sizeof masks.grid);
  for_each_frame(masks, plan, [&](PathFrame& frame) {
    for (auto* words : {&frame.words, &frame.valid_bits})
      out.write(bytes_of(*words).data(), static_cast<std::streamsize>(bytes_of(*words).size()));
  });
  if (out.flush()) return {};
  return Error{"cannot write " + file.string()};
}

template <class T>
std::vector<T> copied(std::span<const std::byte> bytes, size_t count) {
  std::vector<T> out(count);
  if (count > 0) std::memcpy(out.data(), bytes.data(), count * sizeof(T));
  return out;
}

Result<void> render(gpu::BlockingFrame& frame, const gpu::CameraView& camera, const PathPlan& plan, TileGrid& grid,
                    PathFrame& out) {
  const auto reserved = frame.reserve(plan.size.width, plan.size.height);
  if (!reserved) return reserved.error();
  if (const auto rendered = frame.render(camera, *reserved); !rendered) return rendered.error();
  grid = *reserved;
  out.words = copied<uint64_t>(frame.host(gpu::resource::kHostMasks), grid.word_count());
  out.valid_bits = copied<uint64_t>(frame.host(gpu::resource::kHostValidBits), grid.word_count());
  pack(out, grid);
  return {};
}

Result<PathMasks> render_all(const std::string& name, const scenes::ScenePtr& scene, const PathPlan& plan) {
  gpu::RendererOptions options;
  options.device = plan.device;
  auto frame =
      gpu::BlockingFrame::create(options, {"gbuffer", "trace", "readback_masks", "readback_valid_bits"}, scene);
  if (!frame) return frame.error();
  PathMasks masks;
  masks.spots.resize(plan.spots);
  const double duration = path_seconds(*scene);
  for (uint32_t i = 0; i < plan.spots; ++i) {
    say(std::string("  ") + name + ": camera " + std::to_string(i + 1) + " of " + std::to_string(plan.spots));
    const double seconds = duration * (i + 0.5) / plan.spots;
    PathSpot& spot = masks.spots[i];
    const auto at = [&](double when) { return camera_on_path(*scene, when, plan.size); };
    if (auto r = render(**frame, at(seconds), plan, masks.grid, spot.now); !r) return r.error();
    for (const uint32_t age : plan.ages_ms) {
      PathFrame& before = spot.before.emplace_back();
      if (auto r = render(**frame, at(seconds - age / 1e3), plan, masks.grid, before); !r) return r.error();
    }
  }
  masks.device = (*frame)->device().info().name;
  masks.driver = (*frame)->device().info().driver;
  return masks;
}

}  // namespace

Result<PathMasks> masks_along_path(const std::string& scene, const PathPlan& plan) {
  PathMasks kept;
  kept.device = "kept masks";
  kept.scene = scene;
  const auto opened = open_scene(scene);
  if (!opened) return opened.error();
  const std::filesystem::path file =
      plan.folder.empty() ? plan.folder : plan.folder / (key_of(scene, **opened, plan) + ".masks");
  if (!file.empty() && read_kept(file, plan, kept)) {
    place_cameras(**opened, plan, kept);
    return kept;
  }
  auto rendered = render_all(scene, *opened, plan);
  if (!rendered) return rendered;
  rendered->scene = scene;
  place_cameras(**opened, plan, *rendered);
  if (!file.empty())
    if (auto written = keep(file, plan, *rendered); !written) return written.error();
  return rendered;
}

}  // namespace gnomon::bench
