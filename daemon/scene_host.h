// Brings scenes from disk to the device, each once: read on the loader's thread, made resident on the render thread.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "common/inbox.h"
#include "daemon/metrics.h"
#include "daemon/render_inbox.h"
#include "daemon/scene_catalog.h"
#include "daemon/scene_motion.h"

namespace gnomon::daemon {

struct HostedScene {
  scenes::LoadedScene loaded;
  gpu::SceneFootprint on_device;
  LightsNews lights;
};

class SceneHost {
 public:
  using Ready = std::function<void(Result<scenes::LoadedScene>)>;

  // All references outlive the host.
  SceneHost(const SceneCatalog& catalog, RenderInbox& inbox, Metrics& metrics);
  ~SceneHost();  // requests that still wait are not answered

  // Any thread. `ready` is called once, on the caller's, the loader's or the render thread.
  void fetch(const std::string& name, Ready ready);

  // Blocking, for the start: the scene is resident, or why not. Needs a running render thread.
  Result<void> fetch_now(const std::string& name);

  std::map<std::string, HostedScene> resident() const;

  // Any thread. The lights of a resident scene from now on, for those who are still to come.
  void keep_lights(const LightsNews& news);
  LightsNews lights_of(const std::string& name) const;

 private:
  struct Request {
    std::string name;
    Ready ready;
  };

  void load(Request request);
  void keep(const std::string& name, const HostedScene& scene);

  scenes::Registry registry_;
  RenderInbox& inbox_;
  Metrics& metrics_;
  mutable std::mutex mutex_;
  std::map<std::string, HostedScene> resident_;  // guarded by mutex_
  Inbox<Request> requests_;
  std::thread loader_;
};

}  // namespace gnomon::daemon
