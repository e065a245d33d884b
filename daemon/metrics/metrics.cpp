#include "daemon/metrics/metrics.h"

#include "daemon/metrics/link_metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <array>
#include <atomic>
#include <map>

#include "daemon/metrics/process_figures.h"

#include "daemon/config/roster.h"

namespace gnomon::daemon {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Registry;

// Few, since each tenant has them: frames of a fast GPU, of one that is shared, of one that is overrun.
const Histogram::BucketBoundaries kFrameBuckets{0.01, 0.03, 0.1, 0.3};
const Histogram::BucketBoundaries kStageBuckets{0.002, 0.01, 0.05};

Family<Counter>& counter(Registry& registry, const char* name, const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry);
}

Family<Gauge>& gauge(Registry& registry, const char* name, const char* help) {
  return BuildGauge().Name(name).Help(help).Register(registry);
}

struct Stages {
  Histogram *queue, *gpu, *readback, *encode, *send;

  explicit Stages(Family<Histogram>& family) {
    const auto stage = [&](const char* name) { return &family.Add({{"stage", name}}, kStageBuckets); };
    queue = stage("queue");
    gpu = stage("gpu");
    readback = stage("readback");
    encode = stage("encode");
    send = stage("send");
  }

  void observe(const FrameMeta& meta, TimePoint sent) {
    queue->Observe(to_seconds(meta.times.submitted - meta.times.arrival));
    gpu->Observe(to_seconds(meta.times.gpu - meta.times.readback));
    readback->Observe(to_seconds(meta.times.readback));
    encode->Observe(to_seconds(meta.times.encoded - meta.times.encode_began));
    send->Observe(to_seconds(sent - meta.times.encoded));
  }
};

struct DeviceSeries {
  Counter& busy;
  Gauge& up;
  Counter& losses;
  Gauge* sessions;
};

struct TenantSeries {
  Histogram& frame;
  Counter& buffers;
  Counter& bits;
  Counter& coalesced;
  Counter& bytes_sent;
  Counter& queue_seconds;
  Counter& gpu_seconds;
  Counter& late;
  Gauge& share;
  Gauge& expected_share;
  Gauge& lag;
  Gauge& sessions;
};

}  // namespace

struct Metrics::Families {
  Registry registry;
  Family<Counter>& buffers =
      counter(registry, "gnomon_visibility_buffers_total", "Visibility buffers sent; vbps is the rate of this.");
  Family<Counter>& bits = counter(registry, "gnomon_visibility_values_total",
                                  "Visibility values sent: pixels times lights, a bit each.");
  Family<Counter>& coalesced = counter(registry, "gnomon_frames_coalesced_total",
                                       "Views replaced by a newer one before they were rendered.");
  Family<Counter>& bytes = counter(registry, "gnomon_bytes_sent_total", "Bytes of datagrams sent to clients.");
  Family<Counter>& codec_bytes =
      counter(registry, "gnomon_codec_bytes_sent_total", "Bytes of frames sent to clients, by codec.");
  Family<Counter>& dropped =
      counter(registry, "gnomon_frames_dropped_total", "Views and frames dropped, by reason.");
  Counter& datagrams =
      counter(registry, "gnomon_datagrams_received_total", "Datagrams received, good or not.").Add({});
  Family<Counter>& rejected = counter(registry, "gnomon_datagrams_rejected_total",
                                      "Datagrams that were not a view of a session, by reason.");
  Family<Counter>& refusals =
      counter(registry, "gnomon_refusals_total", "Connections that got no session, by reason.");
  Family<Counter>& admin_closed = counter(registry, "gnomon_admin_connections_closed_total",
                                          "Admin connections closed before they had asked, by reason.");
  Family<Counter>& queue_seconds = counter(
      registry, "gnomon_tenant_queue_seconds_total",
      "Time that the tenant's frames waited from their camera's arrival to their start; divide by buffers.");
  Family<Counter>& gpu_seconds =
      counter(registry, "gnomon_tenant_gpu_seconds_total", "Device time that the tenant's frames took.");
  Family<Counter>& late =
      counter(registry, "gnomon_frames_late_total", "Frames sent after the time until which they were of use.");
  // Its series are made when there is something to count: most tenants never lose a frame.
  Family<Counter>& tenant_dropped = counter(registry, "gnomon_tenant_frames_dropped_total",
                                            "Views and frames of the tenant that were dropped, by reason.");
  Family<Counter>& scene_buffers =
      counter(registry, "gnomon_scene_visibility_buffers_total", "Visibility buffers sent, by scene.");
  Family<Counter>& degradations = counter(registry, "gnomon_degradations_total",
                                          "Steps down and up of sessions that the device did not keep up with.");
  Counter& degraded = degradations.Add({{"direction", "down"}});
  Counter& restored = degradations.Add({{"direction", "up"}});
  Family<Gauge>& share =
      gauge(registry, "gnomon_tenant_share_ratio", "The tenant's part of the device time of the last second.");
  Family<Gauge>& expected_share = gauge(registry, "gnomon_tenant_expected_share_ratio",
                                        "Its part by weight, if it had work all through the last second.");
  Family<Gauge>& lag = gauge(registry, "gnomon_tenant_lag_seconds",
                             "Device time that the policy owes the tenant; negative: it had some in advance.");
  Gauge& cost_error = gauge(registry, "gnomon_cost_error_ratio",
                            "Mean error of predicted costs, relative to real ones, in the last second.")
                          .Add({});
  Gauge& jain = gauge(registry, "gnomon_fairness_jain_index",
                      "Jain's index of device time by weight, of the tenants that always had work: 1 is fair.")
                    .Add({});
  Gauge& worst_lag =
      gauge(registry, "gnomon_fairness_worst_lag_seconds", "The largest lag of any tenant, either way.").Add({});
  Family<Gauge>& sessions = gauge(registry, "gnomon_sessions", "Open sessions.");
  Family<Gauge>& resident =
      gauge(registry, "gnomon_scene_resident", "1: the scene is on the device, 0: it is not.");
  Family<Gauge>& load_seconds =
      gauge(registry, "gnomon_scene_load_seconds", "Time that reading the scene took, when it was last loaded.");
  Family<Gauge>& scene_bytes = gauge(registry, "gnomon_scene_memory_bytes", "Host memory that the scene occupies.");
  Family<Gauge>& build_seconds =
      gauge(registry, "gnomon_scene_build_seconds", "Time that building what the tracer needs took.");
  Family<Gauge>& device_bytes =
      gauge(registry, "gnomon_scene_device_memory_bytes", "Device memory that the scene occupies.");
  Family<Gauge>& tracer_bytes = gauge(registry, "gnomon_scene_tracer_memory_bytes",
                                      "Device memory of what the tracer built, as light buffers.");
  Family<Gauge>& from_cache = gauge(registry, "gnomon_scene_light_buffer_cached",
                                    "1: the light buffers were read from the cache, 0: built.");
  Family<Gauge>& built = gauge(registry, "gnomon_scene_light_buffers_built_ratio",
                               "Share of the light buffers' build that is done; until 1, frames cost more.");
  Family<Gauge>& lights =
      gauge(registry, "gnomon_scene_lights",
            "Lights, by state: resting where the tracer built for them, moving, or waiting for the first build.");
  Family<Counter>& rebuilds = counter(registry, "gnomon_scene_light_rebuilds_total",
                                      "Times that light buffers were built anew for changed lights.");
  Family<Gauge>& build = gauge(registry, "gnomon_build_info", "Always 1; the version is the label.");
  Family<Histogram>& stages = BuildHistogram()
                                  .Name("gnomon_stage_seconds")
                                  .Help("Time that frames of all tenants spent in a stage.")
                                  .Register(registry);
  Stages stage{stages};
  Family<Histogram>& frames = BuildHistogram()
                                  .Name("gnomon_frame_seconds")
                                  .Help("Time from a camera's arrival until its frame was sent.")
                                  .Register(registry);
  Family<Counter>& device_busy =
      counter(registry, "gnomon_device_busy_seconds_total", "Time that the device spent on frames.");
  Family<Gauge>& device_up =
      gauge(registry, "gnomon_device_up", "1: the device takes work, 0: it is being made anew.");
  Family<Counter>& device_losses =
      counter(registry, "gnomon_device_losses_total", "Times that the device was lost.");
  Family<Gauge>& device_sessions =
      gauge(registry, "gnomon_device_sessions", "Open sessions that live on the device, where there are several.");
  Gauge& ready = gauge(registry, "gnomon_ready", "1: new clients are served.").Add({});
  Gauge& resident_memory =
      gauge(registry, "gnomon_process_resident_memory_bytes", "Memory of the process, as the system has it.")
          .Add({});
  Gauge& open_files = gauge(registry, "gnomon_process_open_fds", "Open file descriptors.").Add({});
  Gauge& threads = gauge(registry, "gnomon_process_threads", "Threads of the process.").Add({});

  Family<Counter>& all_reloads =
      counter(registry, "gnomon_config_reloads_total", "Configurations read while running, taken or not.");
  Counter& reloads = all_reloads.Add({{"result", "done"}});
  Counter& failed_reloads = all_reloads.Add({{"result", "failed"}});
  Family<Counter>& limit_refusals =
      counter(registry, "gnomon_tenant_refusals_total", "Sessions refused a tenant, by the limit that they met.");

  std::array<std::atomic<Counter*>, protocol::kCodecs.size()> codecs{};  // by CodecId; null: not used yet
  // Reserved once: growing moves nothing, so that others may look at the series that were there before.
  LinkMetrics links{registry};
  std::vector<DeviceSeries> devices;
  std::vector<std::string> names;  // of the tenants
  std::vector<std::unique_ptr<TenantSeries>> tenants;
  std::map<std::string, Counter*> scenes;  // by label
  std::vector<Counter*> faults;            // by Fault; null: made when there is something to count

  Family<Counter>& family_of(FaultKind kind) {
    switch (kind) {
      case FaultKind::datagram_rejected: return rejected;
      case FaultKind::frame_dropped: return dropped;
      case FaultKind::refusal: return refusals;
      case FaultKind::admin_closed: return admin_closed;
    }
    return dropped;
  }

  // Made when a codec is used first, and kept: a frame never waits for a scrape that walks the family.
  Counter& bytes_of(protocol::CodecId codec) {
    std::atomic<Counter*>& kept = codecs[static_cast<size_t>(codec)];
    if (!kept) kept = &codec_bytes.Add({{"codec", std::string(protocol::to_string(codec))}});
    return *kept;
  }

  // One device needs no label.
  void add_devices(size_t count) {
    for (size_t i = 0; i < count; ++i) {
      const prometheus::Labels label =
          count == 1 ? prometheus::Labels{} : prometheus::Labels{{"device", std::to_string(i)}};
      devices.push_back({device_busy.Add(label), device_up.Add(label), device_losses.Add(label),
                         count == 1 ? nullptr : &device_sessions.Add(label)});
    }
  }

  Counter& counter_of(const FaultRow& row) { return family_of(row.kind).Add({{"reason", row.label}}); }

  void add_tenant(const std::string& name) {
    auto series = std::make_unique<TenantSeries>(TenantSeries{
        frames.Add({{"tenant", name}}, kFrameBuckets), buffers.Add({{"tenant", name}}),
        bits.Add({{"tenant", name}}), coalesced.Add({{"tenant", name}}), bytes.Add({{"tenant", name}}),
        queue_seconds.Add({{"tenant", name}}), gpu_seconds.Add({{"tenant", name}}), late.Add({{"tenant", name}}),
        share.Add({{"tenant", name}}), expected_share.Add({{"tenant", name}}), lag.Add({{"tenant", name}}),
        sessions.Add({{"tenant", name}})});
    tenants.push_back(std::move(series));
    names.push_back(name);
  }
};

Metrics::Metrics(const std::vector<std::string>& tenants, const std::vector<std::string>& scenes,
                 const std::string& version, size_t devices)
    : families_(std::make_unique<Families>()) {
  families_->add_devices(devices);
  families_->names.reserve(kMostTenants);
  families_->tenants.reserve(kMostTenants);
  for (const std::string& scene : scenes)
    families_->scenes[scene] = &families_->scene_buffers.Add({{"scene", scene}});
  families_->scenes[kOtherScenes] = &families_->scene_buffers.Add({{"scene", kOtherScenes}});
  know_tenants(tenants);
  for (const FaultRow& row : fault_table()) {
    // Refusals are rare and there are many reasons.
    const bool rare = row.kind == FaultKind::refusal || row.kind == FaultKind::admin_closed;
    families_->faults.push_back(rare ? nullptr : &families_->counter_of(row));
  }
  families_->build.Add({{"version", version}}).Set(1);
}

Metrics::~Metrics() = default;

void Metrics::know_tenants(const std::vector<std::string>& tenants) {
  for (size_t i = families_->tenants.size(); i < tenants.size(); ++i) families_->add_tenant(tenants[i]);
}

void Metrics::report(Fault fault, log::Fields fields) {
  const FaultRow& row = row_of(fault);
  Counter* known = families_->faults[static_cast<size_t>(fault)];
  (known ? *known : families_->counter_of(row)).Increment();
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
  const auto known = families_->scenes.find(scene);
  (known != families_->scenes.end() ? known->second : families_->scenes.at(kOtherScenes))->Increment();
  series.buffers.Increment();
  series.bits.Increment(static_cast<double>(meta.spec.traced_bits()));
  series.bytes_sent.Increment(static_cast<double>(bytes));
  series.queue_seconds.Increment(to_seconds(meta.times.submitted - meta.times.arrival));
  families_->bytes_of(meta.spec.codec).Increment(static_cast<double>(bytes));
  series.frame.Observe(to_seconds(sent - meta.times.arrival));
  families_->stage.observe(meta, sent);
  if (sent > meta.times.deadline) series.late.Increment();
}

void Metrics::datagram_received() { families_->datagrams.Increment(); }
void Metrics::coalesced(TenantId tenant) { families_->tenants[tenant.value]->coalesced.Increment(); }
void Metrics::session_opened(TenantId tenant) { families_->tenants[tenant.value]->sessions.Increment(); }
void Metrics::session_closed(TenantId tenant) { families_->tenants[tenant.value]->sessions.Decrement(); }

void Metrics::device_busy(uint32_t device, TenantId tenant, Nanoseconds gpu_time) {
  families_->devices[device].busy.Increment(to_seconds(gpu_time));
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
}

void Metrics::reloaded(bool done) { (done ? families_->reloads : families_->failed_reloads).Increment(); }

void Metrics::degraded(bool down) { (down ? families_->degraded : families_->restored).Increment(); }

void Metrics::device_lost(uint32_t device) { families_->devices[device].losses.Increment(); }

void Metrics::device_up(uint32_t device, bool up) { families_->devices[device].up.Set(up ? 1 : 0); }

void Metrics::device_sessions(uint32_t device, uint32_t sessions) {
  if (Gauge* gauge = families_->devices[device].sessions) gauge->Set(sessions);
}

void Metrics::ready(bool ready) { families_->ready.Set(ready ? 1 : 0); }

void Metrics::link(const LinkReport& report) { families_->links.count(report); }

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

void Metrics::scene_resident(const std::string& scene, const scenes::LoadedScene& loaded,
                             const gpu::SceneFootprint& on_device) {
  if (!families_->scenes.contains(scene)) return;
  const prometheus::Labels labels{{"scene", scene}};
  families_->resident.Add(labels).Set(1);
  families_->load_seconds.Add(labels).Set(loaded.load_seconds);
  families_->build_seconds.Add(labels).Set(on_device.tracer_build_seconds);
  families_->scene_bytes.Add(labels).Set(static_cast<double>(loaded.memory_bytes));
  families_->device_bytes.Add(labels).Set(static_cast<double>(on_device.memory_bytes));
  families_->tracer_bytes.Add(labels).Set(static_cast<double>(on_device.tracer_memory_bytes));
  families_->from_cache.Add(labels).Set(on_device.tracer_from_cache ? 1 : 0);
}

void Metrics::scene_unloaded(const std::string& scene) {
  if (!families_->scenes.contains(scene)) return;
  const prometheus::Labels labels{{"scene", scene}};
  for (auto* family :
       {&families_->resident, &families_->scene_bytes, &families_->device_bytes, &families_->tracer_bytes}) {
    family->Add(labels).Set(0);
  }
}

void Metrics::scene_lights(const std::string& scene, const gpu::LightState& lights) {
  if (!families_->scenes.contains(scene)) return;
  families_->lights.Add({{"scene", scene}, {"state", "resting"}}).Set(lights.resting);
  families_->lights.Add({{"scene", scene}, {"state", "moving"}}).Set(lights.moving);
  families_->lights.Add({{"scene", scene}, {"state", "unbuilt"}}).Set(lights.unbuilt);
  families_->rebuilds.Add({{"scene", scene}});
}

void Metrics::scene_built(const SceneReport& scene) {
  if (families_->scenes.contains(scene.name))
    families_->built.Add({{"scene", scene.name}}).Set(scene.built_share());
}

void Metrics::lights_rebuilt(const std::string& scene) {
  if (!families_->scenes.contains(scene)) return;
  families_->rebuilds.Add({{"scene", scene}}).Increment();
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
  const ProcessFigures process = process_figures();
  families_->resident_memory.Set(process.resident_bytes);
  families_->open_files.Set(process.open_files);
  families_->threads.Set(process.threads);
  return prometheus::TextSerializer().Serialize(families_->registry.Collect());
}

}  // namespace gnomon::daemon
