// What the daemon counts, for Prometheus. Labels are bounded: tenants, scenes, stages and reasons, never sessions.
//
// Any thread. The series of every frame's way are made at the start, and counting in them touches one atomic or one
// short lock of one histogram, so that a scrape does not delay them. Rare faults, refusals and a tenant's dropped frames
// are series made when they first happen, under the lock of their family.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "daemon/frame/frame.h"
#include "daemon/metrics/device_metrics.h"
#include "daemon/metrics/faults.h"
#include "daemon/metrics/link_metrics.h"
#include "daemon/metrics/link_report.h"
#include "daemon/metrics/operation_metrics.h"
#include "daemon/metrics/scene_metrics.h"
#include "daemon/metrics/share_report.h"
#include "scheduler/admission_control.h"

namespace gnomon::daemon {

// Since the start.
struct TenantTotals {
  double buffers = 0, bits = 0, bytes = 0;
};

class Metrics {
 public:
  // The tenants' names in the order of their ids (at most kMostTenants), and the configured scenes.
  Metrics(const std::vector<std::string>& tenants, const std::vector<std::string>& scenes,
          const std::string& version, size_t devices = 1);
  ~Metrics();

  // Makes the series of those of `tenants` that the constructor and earlier calls have not made. One thread at a time;
  // nothing may be counted for them before.
  void add_tenants(const std::vector<std::string>& tenants);

  // Counts a fault and logs it as the table says.
  void report(Fault fault, log::Fields fields = {});

  // A frame's last datagram has been handed to the kernel.
  void frame_sent(TenantId tenant, const std::string& scene, const FrameMeta& meta, TimePoint sent, size_t bytes);

  SceneMetrics& scenes();
  DeviceMetrics& devices();
  OperationMetrics& operation();

  void datagram_received();                              // counts datagrams of every kind, accepted or not
  void views_received(TenantId tenant, uint32_t count);  // those replaced on the way to a device included
  void coalesced(TenantId tenant);
  void session_opened(TenantId tenant);
  void session_closed(TenantId tenant);
  void device_busy(uint32_t device, TenantId tenant, Nanoseconds gpu_time);
  // report() of one session's fault; the line in the log names the session and its tenant.
  void report(TenantId tenant, SessionId session, Fault fault, const std::string& why = {});
  // report() of a fault that cost the session a view or a frame, which also counts for its tenant.
  void dropped(TenantId tenant, SessionId session, Fault fault, const std::string& why = {});
  const std::string& name(TenantId tenant) const;
  void shares(const ShareReport& report);
  void degraded(bool down);
  LinkMetrics& links();
  void refused(TenantId tenant, std::string_view limit);

  TenantTotals totals(TenantId tenant) const;
  uint64_t count_of(Fault fault) const;
  uint64_t datagrams() const;  // received

  std::string text() const;  // Prometheus' text format

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace gnomon::daemon
