#include "daemon/metrics/metrics.h"

#include <prometheus/text_serializer.h>

#include <algorithm>
#include <iterator>

#include "common/audit_file.h"
#include "common/patient_stream.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/metrics/metric_families.h"
#include "daemon/metrics/process_metrics.h"

namespace gnomon::daemon {
namespace {

// Series of such faults are made when there is something to count, as a node has room for few: refusals have many
// reasons, and the others happen once a session at most, or once in the life of a daemon or a device.
bool is_rare(const FaultRow& row) {
  switch (row.fault) {
    case Fault::feedback_invented:
    case Fault::path_unproven:
    case Fault::view_draining:
    case Fault::device_lost:
    case Fault::submit_failed:
    case Fault::encode_failed: return true;
    default: break;
  }
  switch (row.kind) {
    case FaultKind::refusal:
    case FaultKind::admin_closed:
    case FaultKind::admin_refused: return true;
    case FaultKind::datagram_rejected:
    case FaultKind::frame_dropped: return false;
  }
  return false;
}

// Most frames that are late are never sent: neither devices nor links go on with one that is of no use any more.
bool is_late(Fault fault) { return fault == Fault::deadline_unreachable || fault == Fault::link_too_slow; }

}  // namespace

Metrics::Metrics(const std::vector<std::string>& tenants, const std::vector<std::string>& scenes,
                 const std::string& version, size_t devices)
    : families_(std::make_unique<Families>(scenes, devices)) {
  families_->names.reserve(kMostTenants);
  families_->tenants.reserve(kMostTenants);
  add_tenants(tenants);
  for (const FaultRow& row : fault_table()) {
    families_->faults.push_back(is_rare(row) ? nullptr : &families_->counter_of(row));
  }
  families_->build.Add({{"version", version}}).Set(1);
}

Metrics::~Metrics() = default;

void Metrics::add_tenants(const std::vector<std::string>& tenants) {
  for (size_t i = families_->tenants.size(); i < tenants.size(); ++i) families_->add_tenant(tenants[i]);
}

void Metrics::report(Fault fault, log::Fields fields) {
  const FaultRow& row = row_of(fault);
  Counter* known = families_->faults[static_cast<size_t>(fault)];
  (known ? *known : families_->counter_of(row)).Increment();
  if (is_failed_authentication(fault)) log::audit_refusal("client refused", fields);
  switch (row.level) {
    case log::Level::debug: return log::debug(row.event, fields);
    case log::Level::info: return log::info(row.event, fields);
    case log::Level::warning: return log::warning(row.event, fields);
    case log::Level::error: return log::error(row.event, fields);
    case log::Level::off: return;
  }
}

void Metrics::frame_sent(TenantId tenant, const std::string& scene, const FrameMeta& meta, TimePoint sent,
                         size_t bytes) {
  TenantSeries& series = *families_->tenants[tenant.value];
  families_->scenes.frame_sent(scene);
  series.buffers.Increment();
  series.bits.Increment(static_cast<double>(meta.spec.traced_bits));
  series.bytes_sent.Increment(static_cast<double>(bytes));
  series.queue_seconds.Increment(to_seconds(meta.times.submitted - meta.times.arrival));
  families_->bytes_of(meta.spec.codec).Increment(static_cast<double>(bytes));
  series.frame.Observe(to_seconds(sent - meta.times.arrival));
  families_->stage.observe(meta, sent);
  if (sent > meta.times.deadline) series.late.Increment();
}

SceneMetrics& Metrics::scenes() { return families_->scenes; }
DeviceMetrics& Metrics::devices() { return families_->devices; }
OperationMetrics& Metrics::operation() { return families_->operation; }

void Metrics::datagram_received() { families_->datagrams.Increment(); }
void Metrics::views_received(TenantId tenant, uint32_t count) {
  families_->tenants[tenant.value]->views.Increment(count);
}
void Metrics::coalesced(TenantId tenant) { families_->tenants[tenant.value]->coalesced.Increment(); }
void Metrics::session_opened(TenantId tenant) { families_->tenants[tenant.value]->sessions.Increment(); }
void Metrics::session_closed(TenantId tenant) { families_->tenants[tenant.value]->sessions.Decrement(); }

void Metrics::device_busy(uint32_t device, TenantId tenant, Nanoseconds gpu_time) {
  families_->devices.busy(device, gpu_time);
  families_->tenants[tenant.value]->gpu_seconds.Increment(to_seconds(gpu_time));
}

const std::string& Metrics::name(TenantId tenant) const { return families_->names[tenant.value]; }

void Metrics::report(TenantId tenant, SessionId session, Fault fault, const std::string& why) {
  if (why.empty()) return report(fault, {{"session", session.value}, {"tenant", name(tenant)}});
  report(fault, {{"session", session.value}, {"tenant", name(tenant)}, {"why", why}});
}

void Metrics::dropped(TenantId tenant, SessionId session, Fault fault, const std::string& why) {
  report(tenant, session, fault, why);
  const prometheus::Labels labels{{"tenant", name(tenant)}, {"reason", row_of(fault).label}};
  families_->tenant_dropped.Add(labels).Increment();
  if (is_late(fault)) families_->tenants[tenant.value]->late.Increment();
}

void Metrics::degraded(bool down) { (down ? families_->degraded : families_->restored).Increment(); }

LinkMetrics& Metrics::links() { return families_->links; }

void Metrics::refused(TenantId tenant, std::string_view limit) {
  const prometheus::Labels labels{{"tenant", families_->names[tenant.value]}, {"limit", std::string(limit)}};
  families_->limit_refusals.Add(labels).Increment();
}

void Metrics::shares(const ShareReport& report) {
  double error = 0;
  int served = 0;
  for (size_t i = 0; i < report.tenants.size(); ++i) {
    const TenantReport& tenant = report.tenants[i];
    TenantSeries& series = *families_->tenants[i];
    series.share.Set(tenant.share);
    series.expected_share.Set(tenant.expected_share);
    series.lag.Set(to_seconds(tenant.lag));
    error += tenant.predicted_error;
    served += tenant.share > 0;
  }
  families_->cost_error.Set(served > 0 ? error / served : 0);
  families_->jain.Set(report.jain);
  families_->worst_lag.Set(to_seconds(report.worst_lag));
}

TenantTotals Metrics::totals(TenantId tenant) const {
  const TenantSeries& series = *families_->tenants[tenant.value];
  TenantTotals totals;
  totals.buffers = series.buffers.Value();
  totals.bits = series.bits.Value();
  totals.bytes = series.bytes_sent.Value();
  return totals;
}

uint64_t Metrics::count_of(Fault fault) const {
  return static_cast<uint64_t>(families_->counter_of(row_of(fault)).Value());
}

uint64_t Metrics::datagrams() const { return static_cast<uint64_t>(families_->datagrams.Value()); }

std::string Metrics::text() const {
  auto families = families_->registry.Collect();
  std::ranges::move(process_families(process_stats()), std::back_inserter(families));
  families.push_back(audit_family(log::unwritten_audit().lines));
  families.push_back(log_family(log::unwritten_log_lines()));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace gnomon::daemon
