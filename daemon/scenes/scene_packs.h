// Scenes as browsers get them (web/PACK.md): each made once while its scene is resident, when the first browser asks for
// it, and kept with the scene, compressed, until that leaves. It counts in the account of the scenes' memory.
//
// A thread of its own makes them, at a low priority: it copies and compresses for seconds what the confined worker has
// checked already, which would make that worker read the whole scene a second time.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "daemon/scenes/scene_host.h"

namespace gnomon::daemon {

struct ScenePack {
  std::string sha256;                                  // of the pack, in hexadecimal digits
  uint64_t bytes = 0;                                  // of the pack
  std::shared_ptr<const std::vector<uint8_t>> packed;  // in Brotli
};
using ScenePackPtr = std::shared_ptr<const ScenePack>;

class ScenePacks {
 public:
  using Make = std::function<Result<ScenePack>(const scenes::Scene&)>;
  using Ready = std::function<void(Result<ScenePackPtr>)>;

  // `host` outlives this.
  explicit ScenePacks(SceneHost& host, Make make = make_pack);
  ~ScenePacks();  // blocks until a pack that is being made is done; who waits is not answered

  // Any thread. `ready` is called once, on the caller's thread or that which makes packs. The scene is used meanwhile.
  void get(const std::string& name, SceneForUse scene, Ready ready);

  // Blocking. Error: the scene makes no pack that browsers can hold, or there is no memory.
  static Result<ScenePack> make_pack(const scenes::Scene& scene);

 private:
  struct Wanted {
    std::string name;
    SceneForUse scene;
  };

  void serve();  // the thread
  void finish(const Wanted& wanted, Result<ScenePackPtr> made);

  SceneHost& host_;
  const Make make_;
  std::mutex mutex_;  // held for look-ups; never while the host is called
  std::condition_variable changed_;
  std::map<SceneId, std::vector<Ready>> waiting_;  // for those that are wanted or being made; guarded by mutex_
  std::deque<Wanted> wanted_;                      // guarded by mutex_
  bool ending_ = false;                            // guarded by mutex_
  std::thread thread_;
};

}  // namespace gnomon::daemon
