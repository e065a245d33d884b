// The daemon as a whole: every part made, connected and, in the end, stopped in the right order.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/published.h"
#include "daemon/admin/admin.h"
#include "daemon/admin/operations.h"
#include "daemon/config/config.h"
#include "daemon/encode/encode_pool.h"
#include "daemon/net/server.h"
#include "daemon/render/device_pool.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

class Daemon final : private FrameSink {
 public:
  struct Options {
    Config config;                                // scene files found, passes named
    std::vector<RendererFactory> make_renderers;  // one for each device
    std::string version;
    std::function<void()> on_drain = {};           // any thread: an operator asks for what SIGTERM asks for
    std::function<void(const Error&)> on_failure;  // from a render thread, once: no device is left
    // Reads the configuration anew and calls reload() on the main thread, then the argument. Any thread may ask.
    std::function<void(std::function<void(Result<void>)>)> ask_for_reload = {};
  };

  // Returns when clients are served: device open, scenes resident, ports open. A client of a scene that is resident
  // before the others is served at once. Error: which of them failed, and why.
  static Result<std::unique_ptr<Daemon>> start(Options options);
  ~Daemon();  // drains without waiting for clients

  // Admits nobody, tells the clients, waits up to server.drain_timeout_ms for them to leave, finishes the frames in
  // flight and closes. A device that hangs or a scene that is being read makes it wait for them.
  void drain();

  // In the place of drain(), where no device is left: clients are told nothing, and whoever comes after us with the same
  // memory goes on with their sessions.
  void give_up();

  // Shares the device on the terms of `next` from now on and takes its tenants, limits and log level, for new connections
  // the certificates that it names, and the operators' token: their files are read again. No session is dropped, but
  // those of tenants that it names no more. What else differs needs a restart, which the log says. The main thread.
  // An error in the place of a configuration is counted and given back.
  Result<void> reload(const Result<Config>& next);

  // The session's frames are coded so from the next one on; its client must have said that it decodes this. Any thread.
  void choose_codec(SessionId session, protocol::CodecId codec) { devices_.choose_codec({session, codec}); }

  uint16_t control_port() const { return server_->control_port(); }
  std::vector<uint16_t> data_ports() const { return server_->data_ports(); }
  uint16_t admin_port() const { return admin_->port(); }
  protocol::Pin pin() const { return (*tls_.get())->pin; }  // of new connections
  Metrics& metrics() { return metrics_; }
  std::vector<Heartbeat*> heartbeats() { return devices_.heartbeats(); }  // for one watchdog
  void alive(TimePoint at) { health_.alive_at = at; }                     // it found them all alive
  std::string summary() const;                                            // one line; any thread

 private:
  Daemon(Options options, SceneCatalog catalog);

  Result<void> apply(const Config& next);
  Result<void> bring_up();
  Result<void> open_devices();
  void on_rendered(RenderedFrame frame) override;
  void on_degraded(const SessionDegraded& session) override;
  void on_lights(const LightsUpdate& lights) override;
  void open_encoders();
  Result<void> open_store();
  Result<void> open_admin();
  void stop();

  // What stands below may use what stands above, and goes first; stop() has ended all threads before.
  const Options options_;
  const SceneCatalog catalog_;
  Health health_;
  Metrics metrics_;
  SessionLimits session_limits_;
  std::unique_ptr<SessionStore> store_;
  DevicePool devices_;
  Published<SharingPolicy> sharing_policy_;
  Published<TenantDirectory> tenant_directory_;
  std::string tracer_;
  PublishedTls tls_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<EncodePool> encode_pool_;
  std::unique_ptr<SceneHost> scenes_;
  std::unique_ptr<Operations> operations_;
  std::unique_ptr<Admin> admin_;
};

}  // namespace gnomon::daemon
