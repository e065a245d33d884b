// What the daemon counts, for Prometheus. Labels are bounded: tenants, scenes, stages and reasons, never sessions.
//
// Any thread. Every series is made at the start; counting touches one atomic or one short lock of one histogram, so
// that a scrape never holds up a frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "daemon/frame/frame.h"
#include "daemon/metrics/faults.h"
#include "daemon/metrics/link_report.h"
#include "daemon/metrics/share_report.h"
#include "daemon/metrics/status.h"
#include "scenes/registry.h"
#include "scheduler/admission.h"

namespace gnomon::daemon {

// Clients may ask for files beside the configured scenes: all of those share this label.
inline constexpr const char* kOtherScenes = "other";

// Since the start.
struct TenantTotals {
  double buffers = 0, bits = 0, bytes = 0;
};

class Metrics {
 public:
  // The tenants' names in the order of their ids (at most kMostTenants), and the configured scenes. Of several devices
  // each has series of its own, by number.
  Metrics(const std::vector<std::string>& tenants, const std::vector<std::string>& scenes,
          const std::string& version, size_t devices = 1);
  ~Metrics();

  // Makes the series of further tenants: those of `tenants` beyond the ones known. One thread at a time; nobody counts
  // for them before.
  void know_tenants(const std::vector<std::string>& tenants);

  // Counts a fault and logs it as the table says.
  void report(Fault fault, log::Fields fields = {});

  // A frame's last datagram has been handed to the kernel.
  void frame_sent(TenantId tenant, const std::string& scene, const FrameMeta& meta, TimePoint sent, size_t bytes);

  void datagram_received();  // of whatever kind
  void coalesced(TenantId tenant);
  void session_opened(TenantId tenant);
  void session_closed(TenantId tenant);
  void device_busy(uint32_t device, TenantId tenant, Nanoseconds gpu_time);
  // report(), of one session; the line in the log says which and whose.
  void report(TenantId tenant, SessionId session, Fault fault, const std::string& why = {});
  // The same, of its view or frame.
  void dropped(TenantId tenant, SessionId session, Fault fault, const std::string& why = {});
  const std::string& name(TenantId tenant) const;
  void shares(const ShareReport& report);
  void reloaded(bool done);
  void degraded(bool down);
  void device_lost(uint32_t device);
  void device_up(uint32_t device, bool up);
  void device_sessions(uint32_t device, uint32_t sessions);  // where there are several
  void ready(bool ready);
  void link(const LinkReport& report);
  void refused(TenantId tenant, std::string_view limit);
  // Of a configured scene; others have no series.
  void scene_resident(const std::string& scene, const scenes::LoadedScene& loaded,
                      const gpu::SceneFootprint& on_device);

  void scene_unloaded(const std::string& scene);

  // The same.
  void scene_lights(const std::string& scene, const gpu::LightState& lights);
  void scene_built(const SceneReport& scene);
  void lights_rebuilt(const std::string& scene);

  TenantTotals totals(TenantId tenant) const;
  uint64_t count_of(Fault fault) const;
  uint64_t datagrams() const;  // received

  std::string text() const;  // Prometheus' text format

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace gnomon::daemon
