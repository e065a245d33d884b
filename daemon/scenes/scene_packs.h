// Scenes as browsers get them (web/PACK.md): each made once while its scene is resident, when the first browser asks for
// it, and kept with the scene, compressed, until that leaves. It counts in the account of the scenes' memory.
//
// Threads of its own make them, at a low priority, for one tenant no more than one at a time: they copy and compress for
// seconds what the confined worker has checked already, which would make that worker read the whole scene a second time.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/fair_queue.h"
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
  ~ScenePacks();  // blocks until packs that are being made are done; who waits is not answered

  // Any thread. `ready` is called once, unless it was given up, on the caller's thread or one that makes packs. The scene
  // is used meanwhile.
  using WaitId = StrongId<struct PackWaitTag, uint64_t>;
  WaitId get(const std::string& name, SceneForUse scene, SceneAsker asker, Ready ready);
  // Any thread. `ready` is not called from now on, unless it is being called. What nobody waits for any more is not begun.
  void give_up(WaitId wait);

  // Blocking. Error: the scene makes no pack that browsers can hold, or there is no memory.
  static Result<ScenePack> make_pack(const scenes::Scene& scene);

 private:
  struct Wanted {
    std::string name;
    SceneForUse scene;
    SceneAsker asker;
  };
  struct Waiting {
    WaitId id;
    Ready ready;
  };
  // A pack that somebody waits for: in the queues of all who do, or being made.
  struct Awaited {
    std::vector<Waiting> waiting;
    std::set<SceneAsker> queues;
    bool begun = false;
  };

  void serve();                      // a thread
  bool begin(const Wanted& wanted);  // false if it is made or given up; with mutex_ held
  void make(const Wanted& wanted);
  void finish(const Wanted& wanted, Result<ScenePackPtr> made);

  SceneHost& host_;
  const Make make_;
  std::mutex mutex_;  // held for look-ups; never while the host is called
  std::condition_variable changed_;
  std::map<SceneId, Awaited> awaited_;    // guarded by mutex_
  FairQueue<SceneAsker, Wanted> wanted_;  // guarded by mutex_
  uint64_t last_wait_ = 0;                // guarded by mutex_
  bool ending_ = false;                   // guarded by mutex_
  std::vector<std::thread> threads_;
};

}  // namespace gnomon::daemon
