#include "daemon/scenes/scene_packs.h"

#include <utility>

#include "common/brotli.h"
#include "common/niceness.h"
#include "common/within_memory.h"
#include "daemon/security/digests.h"
#include "daemon/security/tokens.h"
#include "scenes/web_pack.h"

namespace gnomon::daemon {
namespace {

constexpr int kNice = 10;         // beside threads that frames wait for
constexpr uint32_t kThreads = 2;  // one of them is for another tenant

std::span<const uint8_t> as_numbers(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
}

}  // namespace

Result<ScenePack> ScenePacks::make_pack(const scenes::Scene& scene) {
  const auto pack = scenes::web_pack(scene);
  if (!pack) return pack.error();
  const auto packed = brotli(*pack);
  if (!packed) return packed.error();
  const auto bytes = as_numbers(*packed);
  return ScenePack{to_hex(sha256(as_numbers(*pack))), pack->size(),
                   std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end())};
}

ScenePacks::ScenePacks(SceneHost& host, Make make) : host_(host), make_(std::move(make)), wanted_(kThreads) {
  for (uint32_t i = 0; i < kThreads; ++i) threads_.emplace_back([this] { serve(); });
}

ScenePacks::~ScenePacks() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

ScenePacks::WaitId ScenePacks::get(const std::string& name, SceneForUse scene, SceneAsker asker, Ready ready) {
  WaitId id;
  if (scene.pack) {
    ready(scene.pack);
    return id;
  }
  {
    std::lock_guard lock(mutex_);
    id.value = ++last_wait_;
    Awaited& awaited = awaited_[scene.id];
    if (!awaited.begun && !awaited.queues.contains(asker)) {
      wanted_.push(asker, {name, std::move(scene), asker});
      awaited.queues.insert(asker);
    }
    awaited.waiting.push_back({id, std::move(ready)});
  }
  changed_.notify_all();
  return id;
}

void ScenePacks::give_up(WaitId wait) {
  std::lock_guard lock(mutex_);
  for (auto& [scene, awaited] : awaited_)
    std::erase_if(awaited.waiting, [&](const Waiting& one) { return one.id == wait; });
  wanted_.drop([&](const Wanted& wanted) {
    const auto found = awaited_.find(wanted.scene.id);
    return found == awaited_.end() || found->second.waiting.empty();
  });
  std::erase_if(awaited_, [](const auto& entry) { return !entry.second.begun && entry.second.waiting.empty(); });
}

bool ScenePacks::begin(const Wanted& wanted) {
  const auto found = awaited_.find(wanted.scene.id);
  return found != awaited_.end() && !std::exchange(found->second.begun, true);
}

void ScenePacks::serve() {
  be_nicer(kNice);
  std::unique_lock lock(mutex_);
  std::optional<Wanted> wanted;
  while (true) {
    changed_.wait(lock, [&] { return ending_ || (wanted = wanted_.start()); });
    if (ending_) return;
    const SceneAsker asker = wanted->asker;
    const bool begins = begin(*wanted);
    lock.unlock();
    if (begins) make(*wanted);
    wanted.reset();
    lock.lock();
    wanted_.done(asker);
    changed_.notify_all();
  }
}

void ScenePacks::make(const Wanted& wanted) {
  const auto made = within_memory([&]() -> Result<ScenePackPtr> {
    auto pack = make_(*wanted.scene.scene);
    if (!pack) return pack.error();
    return ScenePackPtr(std::make_shared<const ScenePack>(std::move(*pack)));
  });
  done_or_dropped("a scene pack", [&] { finish(wanted, made); });
}

// The scene is used until here, so that it cannot have left. Who asks after the pack was kept gets it with the scene; who
// got the scene before, and asks only now, has it made again, which is rare and gives the same bytes.
void ScenePacks::finish(const Wanted& wanted, Result<ScenePackPtr> made) {
  if (made) host_.keep_pack(wanted.name, *made, (*made)->packed->size());
  std::vector<Waiting> waiting;
  {
    std::lock_guard lock(mutex_);
    auto entry = awaited_.extract(wanted.scene.id);
    waiting = std::move(entry.mapped().waiting);
  }
  if (made) {
    log::info("scene packed for browsers",
              {{"scene", wanted.name}, {"bytes", (*made)->bytes}, {"packed_bytes", (*made)->packed->size()}});
  } else {
    log::error("scene not packed for browsers", {{"scene", wanted.name}, {"why", made.error().message}});
  }
  for (const Waiting& one : waiting) one.ready(made);
}

}  // namespace gnomon::daemon
