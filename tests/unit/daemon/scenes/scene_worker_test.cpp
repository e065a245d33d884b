// Scenes read by another process: the same scenes, and every end that such a process can come to.
#include "daemon/scenes/scene_worker.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <thread>

#include "daemon/worker/confinement.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using namespace scenes::testing;

SceneWorkerOptions options() {
  return {.program = std::filesystem::path(GNOMON_BINARY_DIR) / "../libexec/gnomon/gnomon-scene-worker"};
}

Result<scenes::ScenePtr> read(const std::filesystem::path& file, const SceneWorkerOptions& how = options(),
                              std::stop_token stop = {}) {
  return load_in_worker(how, {"scene", file}, {}, {.stop = std::move(stop)});
}

// A program in the worker's place.
SceneWorkerOptions instead(const ScratchFolder& folder, const std::string& script) {
  SceneWorkerOptions how = options();
  how.program = folder.write("worker", "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(how.program, std::filesystem::perms::owner_all);
  return how;
}

TEST(SceneWorker, ReadsWhatTheLoaderReads) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.glb", triangle_file().glb());
  const auto here = scenes::load_scene(file);
  const auto there = read(file);
  ASSERT_TRUE(here);
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ((*there)->content_hash, (*here)->content_hash);
  EXPECT_EQ((*there)->name, (*here)->name);
  EXPECT_EQ((*there)->meshes[0].primitives[0].positions, (*here)->meshes[0].primitives[0].positions);
}

TEST(SceneWorker, TellsHowFarTheReadingIs) {
  const auto file = std::filesystem::path(GNOMON_BINARY_DIR) / "../share/gnomon/scenes/living_room.glb";
  std::vector<double> shares;
  const auto scene =
      load_in_worker(options(), {"scene", file}, {}, {.on_share = [&](double share) { shares.push_back(share); }});
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.front(), 0);
  EXPECT_NEAR(shares.back(), 0.95, 1e-9) << "the last cluster";
}

TEST(SceneWorker, HandsOnTheLoadersReason) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.gltf", std::string("{}"));
  const auto here = scenes::load_scene(file);
  const auto there = read(file);
  ASSERT_FALSE(here);
  ASSERT_FALSE(there);
  EXPECT_EQ(there.error().message, here.error().message);
}

// The descriptors of a process are as low as there are free ones.
TEST(SceneWorker, ReadsWhicheverDescriptorsItsTaskIsHandedOverIn) {
  const ScratchFolder folder;
  const auto file = folder.write("scene.glb", triangle_file().glb());
  constexpr unsigned kLast = 20;
  close_range(3, kLast, 0);  // what the test was started with
  std::vector<int> taken;
  while (taken.empty() || taken.back() < static_cast<int>(kLast)) {
    taken.push_back(open("/dev/null", O_RDONLY | O_CLOEXEC));
    const auto scene = read(file);
    EXPECT_TRUE(scene) << "after descriptor " << taken.back() << ": " << scene.error().message;
  }
  for (const int descriptor : taken) close(descriptor);
}

// The kernel's signal is what tells it from a lack of memory.
TEST(SceneWorker, ProcessorTimeBeyondItsLimitIsSaidToBeThat) {
  const ScratchFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    if (!limit_resources({.folder = {}, .max_cpu_seconds = 1})) _exit(1);
    for (std::atomic<int> turns = 0;;) ++turns;
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGXCPU);
  const auto scene = read("scene.glb", instead(folder, "kill -XCPU $$"));
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("of processor time"), std::string::npos) << scene.error().message;
}

TEST(SceneWorker, AMissingProgramIsAReason) {
  SceneWorkerOptions how = options();
  how.program = "/nonexistent/gnomon-scene-worker";
  const auto scene = read("scene.glb", how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("cannot be started"), std::string::npos) << scene.error().message;
}

TEST(SceneWorker, ACrashCostsARefusal) {
  const ScratchFolder folder;
  const auto scene = read("scene.glb", instead(folder, "kill -SEGV $$"));
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message, "its reader crashed (signal 11)");
}

TEST(SceneWorker, AnAnswerThatIsNoneIsARefusal) {
  const ScratchFolder folder;
  EXPECT_FALSE(read("scene.glb", instead(folder, "exit 0"))) << "the task is no answer";
  EXPECT_FALSE(read("scene.glb", instead(folder, ": >&3")));
  EXPECT_FALSE(read("scene.glb", instead(folder, "head -c 1000 /dev/urandom >&3")));
  EXPECT_FALSE(read("scene.glb", instead(folder, "exit 1")));
}

TEST(SceneWorker, IsStoppedAtItsDeadline) {
  const ScratchFolder folder;
  SceneWorkerOptions how = instead(folder, "exec sleep 1000");
  how.max_time = 0s;
  const auto scene = read("scene.glb", how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("takes more than"), std::string::npos) << scene.error().message;
}

TEST(SceneWorker, IsStoppedWhenNobodyWaits) {
  const ScratchFolder folder;
  std::stop_source stop;
  std::jthread leaving([&] { stop.request_stop(); });
  const auto scene = read("scene.glb", instead(folder, "exec sleep 1000"), stop.get_token());
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("nobody waits"), std::string::npos) << scene.error().message;
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose programs have no limit of memory
TEST(SceneWorker, MemoryBeyondItsLimitCostsARefusal) {
  const ScratchFolder folder;
  constexpr size_t kVertices = 6'000'000;  // within the loader's limits
  json root = json::parse(triangle_file().gltf());
  std::filesystem::resize_file(folder.write("zeros.bin", std::string()), kVertices * sizeof(glm::vec3));
  root["buffers"][0] = {{"uri", "zeros.bin"}, {"byteLength", kVertices * sizeof(glm::vec3)}};
  root["bufferViews"][0] = {{"buffer", 0}, {"byteLength", kVertices * sizeof(glm::vec3)}};
  root["accessors"][0]["count"] = kVertices;
  root["meshes"][0]["primitives"][0].erase("indices");
  const auto file = folder.write("bomb.gltf", root.dump());
  SceneWorkerOptions how = options();
  how.max_memory_bytes = uint64_t{160} << 20;
  const auto scene = read(file, how);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("memory"), std::string::npos) << scene.error().message;
}
#endif

// A grid of triangles, large enough for several threads.
scenes::WorldMesh grid() {
  scenes::WorldMesh mesh;
  constexpr uint32_t kSide = 120;
  for (uint32_t i = 0; i <= kSide; ++i) {
    for (uint32_t k = 0; k <= kSide; ++k) mesh.positions.push_back({float(i), float((i * k) % 7), float(k)});
  }
  for (uint32_t i = 0; i < kSide; ++i) {
    for (uint32_t k = 0; k < kSide; ++k) {
      const uint32_t at = i * (kSide + 1) + k, next = at + kSide + 1;
      mesh.triangles.push_back({at, at + 1, next});
      mesh.triangles.push_back({next, at + 1, next + 1});
    }
  }
  mesh.opaque_count = static_cast<uint32_t>(mesh.triangles.size());
  return mesh;
}

TEST(WorkerBuilds, AreThoseOfThisProcess) {
  const scenes::WorldMesh mesh = grid();
  const auto here = gpu::builds_here(), there = builds_in_worker(options());
  const auto one = here->bvh(mesh), other = there->bvh(mesh);
  ASSERT_TRUE(one);
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_EQ(other->nodes.size(), one->nodes.size());
  EXPECT_EQ(std::memcmp(other->nodes.data(), one->nodes.data(), one->nodes.size() * sizeof(gpu::BvhNode)), 0);

  gpu::exact::TracedLight light{};
  light.position = {60, 30, 60};
  light.reach = 1000;
  gpu::light_buffer::BuildSettings settings;
  settings.detail.finest_level = 6;
  double last = -1;
  settings.progress = [&](size_t number, double share) {
    EXPECT_EQ(number, 0u);
    EXPECT_GE(share, last);
    last = share;
  };
  const scenes::Bounds bounds{{0, 0, 0}, {120, 6, 120}};
  const auto built = there->light_buffer(mesh, bounds, {&light, 1}, settings);
  EXPECT_EQ(last, 1.0) << "progress crosses the processes";
  settings.progress = {};
  const auto same = here->light_buffer(mesh, bounds, {&light, 1}, settings);
  ASSERT_TRUE(built) << built.error().message;
  ASSERT_TRUE(same);
  EXPECT_EQ(built->entries, same->entries);
  EXPECT_EQ(built->grid, same->grid);
}

TEST(WorkerBuilds, AreStopped) {
  const ScratchFolder folder;
  const auto builds = builds_in_worker(instead(folder, "exec sleep 1000"));
  std::stop_source stop;
  gpu::light_buffer::BuildSettings settings;
  settings.stop = stop.get_token();
  std::jthread leaving([&] { stop.request_stop(); });
  const gpu::exact::TracedLight light{};
  EXPECT_FALSE(builds->light_buffer(grid(), {}, {&light, 1}, settings));
}

TEST(WorkerBuilds, ACrashAndABrokenAnswerCostAnError) {
  const ScratchFolder folder;
  EXPECT_FALSE(builds_in_worker(instead(folder, "kill -SEGV $$"))->bvh(grid()));
  EXPECT_FALSE(builds_in_worker(instead(folder, "head -c 1000 /dev/urandom >&3"))->bvh(grid()));
}

// The folder is all that it sees: a link that leads out of it is no way.
TEST(SceneWorker, ReadsNoFileOfAnotherFolder) {
  const ScratchFolder folder, elsewhere;
  elsewhere.write("secret.bin", std::vector<uint8_t>(36));
  std::filesystem::create_symlink(elsewhere.path() / "secret.bin", folder.path() / "linked.bin");
  GltfFile file = triangle_file();
  json root = json::parse(file.gltf());
  root["buffers"][0] = {{"uri", "linked.bin"}, {"byteLength", 36}};
  EXPECT_FALSE(read(folder.write("scene.gltf", root.dump())));
}

}  // namespace
}  // namespace gnomon::daemon
