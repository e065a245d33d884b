// The daemon as a whole: makes every part, connects them, and stops them in the right order.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/published.h"
#include "daemon/admin/admin.h"
#include "daemon/admin/operations.h"
#include "daemon/config/config.h"
#include "daemon/encode/encode_pool.h"
#include "daemon/net/daemon_certificates.h"
#include "daemon/net/server.h"
#include "daemon/reload_audit.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

class Daemon final : private FrameSink {
 public:
  struct Options {
    Config config;                                // after find_files()
    std::vector<RendererFactory> make_renderers;  // one for each device
    std::string version;
    std::function<void()> on_stop = {};            // an operator wants the end, as SIGTERM does; any thread
    std::function<void(const Error&)> on_failure;  // called once, on a render thread, when no device is left
    // Reads the configuration again and calls reload() on the main thread, then its argument. Any thread may call it.
    std::function<void(std::function<void(Result<std::vector<std::string>>)>)> ask_for_reload = {};
    scenes::SceneReader read_scene = scenes::read_here;
    // Told of a configuration that is applied, so that its caller changes what it made for read_scene and
    // make_renderers: the log of workers, the limit of the cache. On the thread of reload().
    std::function<void(const Config&)> on_reload = {};
  };

  // Blocks until the devices and ports are open and the configured scenes are resident. A client of a scene that is
  // resident before the others is served at once. The error names what failed and why.
  static Result<std::unique_ptr<Daemon>> start(Options options);
  ~Daemon();  // drains without waiting for clients

  // Admits no more clients, notifies those that there are, waits up to server.drain_timeout_ms for them to leave,
  // finishes the frames in flight and closes every session. Blocks longer if a device hangs or a scene is being read.
  void drain();

  // Instead of drain() if no device is left: sessions that can be resumed are left, without a message to their clients,
  // to the next process, which gets the same memory from the service manager.
  void give_up();

  // Applies the scenes, sharing terms, tenants, limits and log of `next`, its certificates (for new connections) and the
  // operators' token, whose files are read again. Each of these is applied on its own: one that cannot be stays as it
  // was, and the error says why, while the others hold; so does what `missing` names, which was found out before. Sessions
  // are closed whose tenant is no longer named or whose credential is no longer accepted. Other differences need a
  // restart, and the error names their keys. Returns what differs from before, key by key. An error in place of a configuration changes nothing. Counted and logged; the
  // audit log's file is opened anew either way, and gets a line with the difference and with `asked_by`. The main thread.
  Result<std::vector<std::string>> reload(const Result<Config>& next, const char* asked_by = "operator",
                                          std::vector<Error> missing = {});

  // Reminds operators in the log of a certificate that expires. Called now and then, on the main thread.
  void remind(std::chrono::sys_seconds now) { certificates_.remind(now); }

  uint16_t control_port() const { return server_->control_port(); }
  const Server& server() const { return *server_; }  // its further ports
  const Admin& admin() const { return *admin_; }
  // Of the certificate for new connections.
  protocol::Pin pin() const { return (*certificates_.published().get())->pin; }
  Metrics& metrics() { return metrics_; }
  std::vector<Heartbeat*> heartbeats() { return devices_.heartbeats(); }  // for one watchdog
  void alive(TimePoint at) { health_.alive_at = at; }                     // the watchdog found all of them alive
  std::string summary() const;                                            // one line; any thread

 private:
  Daemon(Options options, SceneCatalog catalog);

  void apply(const Config& next, std::vector<Error>& kept);
  Result<void> bring_up();
  Result<void> open_devices();
  void on_rendered(RenderedFrame frame) override;
  void on_encoded(EncodedFrame frame) override;
  void on_degraded(const SessionDegraded& session) override;
  void on_lights(const LightsUpdate& lights) override;
  Result<void> open_admin();
  void stop();

  // Each member may use those above it and is destroyed before them; stop() has ended all threads before.
  const Options options_;
  Published<SceneCatalog> catalog_;
  Health health_;
  Metrics metrics_;
  SessionLimits session_limits_;
  KeptOut kept_out_;
  std::unique_ptr<SessionStore> store_;
  DevicePool devices_;
  Published<SharingPolicy> sharing_policy_;
  Published<TenantDirectory> tenant_directory_;
  std::string tracer_;
  DaemonCertificates certificates_;
  std::unique_ptr<WebService> web_;  // nullptr: browsers are not served
  std::unique_ptr<Server> server_;
  std::unique_ptr<EncodePool> encode_pool_;
  std::unique_ptr<SceneLights> lights_;
  std::unique_ptr<SceneHost> scenes_;
  std::unique_ptr<ScenePacks> packs_;  // nullptr: browsers are not served
  std::unique_ptr<Operations> operations_;
  std::unique_ptr<Admin> admin_;
  ReloadAudit reload_audit_;
};

}  // namespace gnomon::daemon
