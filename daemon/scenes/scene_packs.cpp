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

constexpr int kNice = 10;  // beside threads that frames wait for

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

ScenePacks::ScenePacks(SceneHost& host, Make make) : host_(host), make_(std::move(make)) {
  thread_ = std::thread([this] { serve(); });
}

ScenePacks::~ScenePacks() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ScenePacks::get(const std::string& name, SceneForUse scene, Ready ready) {
  if (scene.pack) return ready(scene.pack);
  {
    std::lock_guard lock(mutex_);
    const auto [waiting, first] = waiting_.try_emplace(scene.id);
    waiting->second.push_back(std::move(ready));
    if (first) wanted_.push_back({name, std::move(scene)});
  }
  changed_.notify_all();
}

void ScenePacks::serve() {
  be_nicer(kNice);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !wanted_.empty(); });
    if (ending_) return;
    const Wanted wanted = std::move(wanted_.front());
    wanted_.pop_front();
    lock.unlock();
    const auto made = within_memory([&]() -> Result<ScenePackPtr> {
      auto pack = make_(*wanted.scene.scene);
      if (!pack) return pack.error();
      return ScenePackPtr(std::make_shared<const ScenePack>(std::move(*pack)));
    });
    done_or_dropped("a scene pack", [&] { finish(wanted, made); });
    lock.lock();
  }
}

// The scene is used until here, so that it cannot have left. Who asks after the pack was kept gets it with the scene; who
// got the scene before, and asks only now, has it made again, which is rare and gives the same bytes.
void ScenePacks::finish(const Wanted& wanted, Result<ScenePackPtr> made) {
  if (made) host_.keep_pack(wanted.name, *made, (*made)->packed->size());
  std::vector<Ready> waiting;
  {
    std::lock_guard lock(mutex_);
    const auto entry = waiting_.extract(wanted.scene.id);
    waiting = std::move(entry.mapped());
  }
  if (made) {
    log::info("scene packed for browsers",
              {{"scene", wanted.name}, {"bytes", (*made)->bytes}, {"packed_bytes", (*made)->packed->size()}});
  } else {
    log::error("scene not packed for browsers", {{"scene", wanted.name}, {"why", made.error().message}});
  }
  for (const Ready& ready : waiting) ready(made);
}

}  // namespace gnomon::daemon
