// Brings scenes from disk to the devices, each once: read on the loaders' threads, made resident on the render threads.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/clock.h"
#include "common/fair_queue.h"
#include "daemon/config/config.h"
#include "daemon/frame/scene_use.h"
#include "daemon/metrics/metrics.h"
#include "daemon/render/device_pool.h"
#include "daemon/render/scene_motion.h"
#include "daemon/scenes/requests_in_hand.h"
#include "daemon/scenes/scene_account.h"
#include "daemon/scenes/scene_catalog.h"
#include "daemon/scenes/scene_lights.h"
#include "daemon/scenes/scene_under_way.h"

namespace gnomon::daemon {

struct ScenePack;  // scene_packs.h

// A resident scene for one user. It is not unloaded while `use` exists.
struct SceneForUse : scenes::LoadedScene {
  SceneUse use;
  std::shared_ptr<const ScenePack> pack = nullptr;  // nullptr if none was kept with it yet
};

struct HostedScene {
  scenes::LoadedScene loaded;
  gpu::SceneFootprint on_device;
  LightsUpdate lights;
  uint32_t users = 0;          // when resident() was called
  uint64_t account_bytes = 0;  // what it counts with in the account of memory
};

// `config` lists tenants by id.
SceneMemoryLimits scene_memory_limits(const Config& config);

// The memory that scenes may have.
struct SceneMemory {
  SceneMemoryLimits limits = {};
  uint64_t light_buffer_bytes = 0;  // predicted for a scene; 0: by its number of lights and the devices' room
};

class SceneHost {
 public:
  using Ready = std::function<void(Result<SceneForUse>)>;

  // All references outlive the host. `read`: called by several threads at a time.
  SceneHost(const SceneCatalog& catalog, DevicePool& devices, SceneLights& lights, Metrics& metrics,
            scenes::SceneReader read, SceneMemory memory = {});
  ~SceneHost();  // stops reading; requests that still wait are not answered

  // Any thread. From now on no scene is read, and readers are stopped. Requests that still wait are not answered.
  void stop_reading();
  // Called on the main thread. Blocks until nothing is being read, and calls no `ready` afterwards. What is resident can
  // be asked for as before.
  void stop();

  // Any thread. Makes the scene resident if it is not; scenes of tenants that nobody uses leave for it where memory is
  // short. `ready` is called on the caller's, a loader's or a render thread, or by give_up(): once, but again with an
  // error where memory ran out after the first call.
  FetchId fetch(const std::string& name, Ready ready, SceneAsker asker = std::nullopt);

  // Any thread. Answers a request that still waits to be read with an error. A scene for which nobody waits any more is
  // not read, and its reader is stopped. Other requests are left alone.
  void give_up(FetchId fetch);

  // Any thread. Takes a scene that nobody uses off the devices and out of memory; the next fetch() reads its file
  // again. Error if it is not resident, is in use or is being loaded.
  Result<void> unload(const std::string& name);

  // Any thread. Serves the scenes of `next` from now on, and of those that differ from `before` none that was read before:
  // a scene that nobody uses leaves. Returns the names of those that stay as they were, because sessions use them or they
  // are being loaded; `next` then has them as in `before`.
  std::vector<std::string> change_sources(SceneCatalog& next, const SceneCatalog& before);

  std::map<std::string, HostedScene> resident() const;
  // Any thread. In the order of their names.
  std::vector<SceneUnderWay> under_way() const;

  // Any thread. The predicted memory of all scenes, and its limit (0: none).
  struct MemoryInUse {
    uint64_t bytes = 0, limit_bytes = 0;
  };
  MemoryInUse memory() const;
  void set_memory_limits(SceneMemoryLimits limits);

  // Any thread. Keeps the pack with a resident scene, as long as that stays, and counts its bytes as the scene's.
  // Precondition: the scene is in use.
  void keep_pack(const std::string& name, std::shared_ptr<const ScenePack> pack, uint64_t bytes);

  // Any thread. The current lights of a resident scene, or of one that is about to be, for sessions that are opened later.
  void keep_lights(const LightsUpdate& update);
  LightsUpdate lights_of(const std::string& name) const;

 private:
  struct Request {
    FetchId id;
    std::string name;
    Ready ready;
    SceneAsker asker;

    void refuse(const Error& why) const;
  };
  // A scene that a reader is at work on, and those that wait for it.
  struct Reading {
    std::vector<Request> waiting;
    std::stop_source stop;  // requested when nobody waits any more
    double share = 0;       // of the file's way to a scene
  };

  // For what outlives the host in the devices' queues.
  struct Alive {
    std::mutex mutex;  // taken before the host's
    SceneHost* host;   // nullptr once it is gone; guarded by mutex
  };
  // A request's share of the loaders, until its scene is read and, where it could be, resident. Any thread; it is given
  // back at the end at the latest, whatever memory was short for.
  class Place {
   public:
    Place(std::shared_ptr<Alive> alive, SceneAsker asker) : alive_(std::move(alive)), asker_(asker) {}
    ~Place() { give_back(); }
    void give_back();

   private:
    const std::shared_ptr<Alive> alive_;
    const SceneAsker asker_;
    std::atomic<bool> given_back_ = false;
  };
  using PlacePtr = std::shared_ptr<Place>;

  void serve_requests();  // a loader's thread
  void serve(const Request& request, const PlacePtr& place);
  std::optional<Request> next_request();
  Result<scenes::LoadedScene> read(const Request& request, const std::stop_token& stop);
  Result<void> make_room(const Request& request, const scenes::LoadedScene& loaded);
  bool is_free(const std::string& name) const;  // with mutex_ held
  void take_away(const std::string& name);      // with mutex_ held; the scene is resident
  void bring(Request request, const Result<scenes::LoadedScene>& loaded, const PlacePtr& place);
  Ready counted(const std::string& name, Ready ready);  // with mutex_ held
  void arrive(const Request& request, const scenes::LoadedScene& scene,
              const Result<gpu::SceneFootprint>& on_device);

  const std::shared_ptr<Alive> alive_ = std::make_shared<Alive>();
  scenes::Registry registry_;
  const uint64_t light_buffer_bytes_;
  DevicePool& devices_;
  SceneLights& lights_;
  Metrics& metrics_;
  mutable std::mutex mutex_;
  struct Resident {
    HostedScene scene;
    std::shared_ptr<SceneUses> uses = std::make_shared<SceneUses>(0);  // incremented only under the mutex
    std::shared_ptr<const ScenePack> pack = nullptr;
  };
  std::map<std::string, Resident> resident_;  // guarded by mutex_
  std::multiset<std::string> on_the_way_;     // scenes that are being brought to the devices; guarded by mutex_
  std::map<std::string, LightsUpdate> early_lights_;  // of scenes in on_the_way_; guarded by mutex_
  std::condition_variable changed_;                   // notified when requests_ or ending_ has changed
  SceneAccount account_;                              // guarded by mutex_
  FairQueue<SceneAsker, Request> requests_;           // guarded by mutex_
  RequestsInHand in_hand_;                            // guarded by mutex_
  std::map<std::string, Reading> reading_;            // guarded by mutex_
  struct UnderWay {
    uint32_t requests = 0;
    TimePoint since{};
  };
  std::map<std::string, UnderWay> under_way_;  // whose requests are not answered; guarded by mutex_
  uint64_t last_fetch_ = 0;                    // guarded by mutex_
  bool ending_ = false;                        // guarded by mutex_
  std::vector<std::thread> loaders_;
};

}  // namespace gnomon::daemon
