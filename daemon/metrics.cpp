#include "daemon/metrics.h"

#include "daemon/link_metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <map>

#include "daemon/roster.h"

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

// From a fast GPU's kernel to a frame that nobody waits for any more.
const Histogram::BucketBoundaries kStageBuckets{0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01,
                                                0.02,   0.05,   0.1,   0.2,   0.5,   1};

Family<Counter>& counter(Registry& registry, const char* name, const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry);
}

Family<Gauge>& gauge(Registry& registry, const char* name, const char* help) {
  return BuildGauge().Name(name).Help(help).Register(registry);
}

struct Stages {
  Histogram *queue, *gpu, *readback, *encode, *send, *total;

  Stages(Family<Histogram>& family, const std::string& tenant) {
    const auto stage = [&](const char* name) {
      return &family.Add({{"tenant", tenant}, {"stage", name}}, kStageBuckets);
    };
    queue = stage("queue");
    gpu = stage("gpu");
    readback = stage("readback");
    encode = stage("encode");
    send = stage("send");
    total = stage("total");
  }

  void observe(const FrameMeta& meta, TimePoint sent) {
    queue->Observe(to_seconds(meta.submitted - meta.arrival));
    gpu->Observe(to_seconds(meta.gpu - meta.readback));
    readback->Observe(to_seconds(meta.readback));
    encode->Observe(to_seconds(meta.encoded - meta.encode_began));
    send->Observe(to_seconds(sent - meta.encoded));
    total->Observe(to_seconds(sent - meta.arrival));
  }
};

struct SceneCounters {
  Counter* buffers;
  Counter* bits;
};

struct TenantSeries {
  Stages stages;
  Counter& coalesced;
  Counter& bytes_sent;
  Counter& gpu_seconds;
  Counter& late;
  Counter& degraded;
  Counter& restored;
  Gauge& share;
  Gauge& expected_share;
  Gauge& lag;
  Gauge& cost_error;
  Gauge& sessions;
  std::map<std::string, SceneCounters> scenes;
};

}  // namespace

struct Metrics::Families {
  Registry registry;
  Family<Counter>& buffers =
      counter(registry, "gnomon_visibility_buffers_total", "Visibility buffers sent; vbps is the rate of this.");
  Family<Counter>& bits =
      counter(registry, "gnomon_visibility_bits_total", "Visibility bits sent: pixels times lights.");
  Family<Counter>& coalesced = counter(registry, "gnomon_frames_coalesced_total",
                                       "Views replaced by a newer one before they were rendered.");
  Family<Counter>& bytes = counter(registry, "gnomon_bytes_sent_total", "Bytes of datagrams sent to clients.");
  Family<Counter>& dropped =
      counter(registry, "gnomon_frames_dropped_total", "Views and frames dropped, by reason.");
  Family<Counter>& rejected = counter(registry, "gnomon_datagrams_rejected_total",
                                      "Datagrams that were not a view of a session, by reason.");
  Family<Counter>& refusals =
      counter(registry, "gnomon_refusals_total", "Connections that got no session, by reason.");
  Family<Counter>& gpu_seconds =
      counter(registry, "gnomon_tenant_gpu_seconds_total", "Device time that the tenant's frames took.");
  Family<Counter>& late =
      counter(registry, "gnomon_frames_late_total", "Frames sent after the time until which they were of use.");
  // Its series are made when there is something to count: most tenants never lose a frame.
  Family<Counter>& tenant_dropped = counter(registry, "gnomon_tenant_frames_dropped_total",
                                            "Views and frames of the tenant that were dropped, by reason.");
  Family<Counter>& degradations = counter(registry, "gnomon_degradations_total",
                                          "Steps down and up of sessions that the device did not keep up with.");
  Family<Gauge>& share =
      gauge(registry, "gnomon_tenant_share_ratio", "The tenant's part of the device time of the last second.");
  Family<Gauge>& expected_share = gauge(registry, "gnomon_tenant_expected_share_ratio",
                                        "Its part by weight, if it had work all through the last second.");
  Family<Gauge>& lag = gauge(registry, "gnomon_tenant_lag_seconds",
                             "Device time that the policy owes the tenant; negative: it had some in advance.");
  Family<Gauge>& cost_error = gauge(registry, "gnomon_tenant_cost_error_ratio",
                                    "Mean error of predicted costs, relative to real ones, in the last second.");
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
  Family<Gauge>& average_list =
      gauge(registry, "gnomon_scene_light_buffer_average_list", "Mean length of the light buffers' lists.");
  Family<Gauge>& longest_list =
      gauge(registry, "gnomon_scene_light_buffer_longest_list", "Length of the light buffers' longest list.");
  Family<Gauge>& lights = gauge(registry, "gnomon_scene_lights",
                                "Lights, by state: resting where the tracer built for them, or moving.");
  Family<Counter>& rebuilds = counter(registry, "gnomon_scene_light_rebuilds_total",
                                      "Times that light buffers were built anew for changed lights.");
  Family<Gauge>& build = gauge(registry, "gnomon_build_info", "Always 1; the version is the label.");
  Family<Histogram>& stages = BuildHistogram()
                                  .Name("gnomon_stage_seconds")
                                  .Help("Time that frames spent in a stage; total is from arrival to sent.")
                                  .Register(registry);
  Counter& device_busy =
      counter(registry, "gnomon_device_busy_seconds_total", "Time that the device spent on frames.").Add({});

  Family<Counter>& all_reloads =
      counter(registry, "gnomon_config_reloads_total", "Configurations read while running, taken or not.");
  Counter& reloads = all_reloads.Add({{"result", "done"}});
  Counter& failed_reloads = all_reloads.Add({{"result", "failed"}});
  Family<Counter>& limit_refusals =
      counter(registry, "gnomon_tenant_refusals_total", "Sessions refused a tenant, by the limit that they met.");

  // Reserved once: growing moves nothing, so that others may look at the series that were there before.
  LinkMetrics links{registry, kMostTenants};
  std::vector<std::string> names;  // of the tenants
  std::vector<std::unique_ptr<TenantSeries>> tenants;
  std::vector<std::string> scenes;  // labels
  std::vector<Counter*> faults;     // by Fault

  Family<Counter>& family_of(FaultKind kind) {
    switch (kind) {
      case FaultKind::datagram_rejected: return rejected;
      case FaultKind::frame_dropped: return dropped;
      case FaultKind::refusal: return refusals;
    }
    return dropped;
  }

  void add_tenant(const std::string& name) {
    auto series =
        std::make_unique<TenantSeries>(TenantSeries{{stages, name},
                                                    coalesced.Add({{"tenant", name}}),
                                                    bytes.Add({{"tenant", name}}),
                                                    gpu_seconds.Add({{"tenant", name}}),
                                                    late.Add({{"tenant", name}}),
                                                    degradations.Add({{"tenant", name}, {"direction", "down"}}),
                                                    degradations.Add({{"tenant", name}, {"direction", "up"}}),
                                                    share.Add({{"tenant", name}}),
                                                    expected_share.Add({{"tenant", name}}),
                                                    lag.Add({{"tenant", name}}),
                                                    cost_error.Add({{"tenant", name}}),
                                                    sessions.Add({{"tenant", name}}),
                                                    {}});
    for (const std::string& scene : scenes) {
      const prometheus::Labels labels{{"tenant", name}, {"scene", scene}};
      series->scenes[scene] = {&buffers.Add(labels), &bits.Add(labels)};
    }
    tenants.push_back(std::move(series));
    links.add_tenant(name);
    names.push_back(name);
  }
};

Metrics::Metrics(const std::vector<std::string>& tenants, const std::vector<std::string>& scenes,
                 const std::string& version)
    : families_(std::make_unique<Families>()) {
  families_->names.reserve(kMostTenants);
  families_->tenants.reserve(kMostTenants);
  families_->scenes = scenes;
  families_->scenes.push_back(kOtherScenes);
  know_tenants(tenants);
  for (const FaultRow& row : fault_table()) {
    families_->faults.push_back(&families_->family_of(row.kind).Add({{"reason", row.label}}));
  }
  families_->build.Add({{"version", version}}).Set(1);
}

Metrics::~Metrics() = default;

void Metrics::know_tenants(const std::vector<std::string>& tenants) {
  for (size_t i = families_->tenants.size(); i < tenants.size(); ++i) families_->add_tenant(tenants[i]);
}

void Metrics::report(Fault fault, log::Fields fields) {
  const FaultRow& row = row_of(fault);
  families_->faults[static_cast<size_t>(fault)]->Increment();
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
  const auto known = series.scenes.find(scene);
  const SceneCounters& counters = known != series.scenes.end() ? known->second : series.scenes.at(kOtherScenes);
  counters.buffers->Increment();
  counters.bits->Increment(static_cast<double>(meta.traced_bits()));
  series.bytes_sent.Increment(static_cast<double>(bytes));
  series.stages.observe(meta, sent);
  if (sent > meta.deadline) series.late.Increment();
}

void Metrics::coalesced(TenantId tenant) { families_->tenants[tenant.value]->coalesced.Increment(); }
void Metrics::session_opened(TenantId tenant) { families_->tenants[tenant.value]->sessions.Increment(); }
void Metrics::session_closed(TenantId tenant) { families_->tenants[tenant.value]->sessions.Decrement(); }

void Metrics::device_busy(TenantId tenant, Nanoseconds gpu_time) {
  families_->device_busy.Increment(to_seconds(gpu_time));
  families_->tenants[tenant.value]->gpu_seconds.Increment(to_seconds(gpu_time));
}

void Metrics::dropped(TenantId tenant, Fault fault, log::Fields fields) {
  report(fault, std::move(fields));
  const prometheus::Labels labels{{"tenant", families_->names[tenant.value]}, {"reason", row_of(fault).label}};
  families_->tenant_dropped.Add(labels).Increment();
}

void Metrics::reloaded(bool done) { (done ? families_->reloads : families_->failed_reloads).Increment(); }

void Metrics::degraded(TenantId tenant, bool down) {
  TenantSeries& series = *families_->tenants[tenant.value];
  (down ? series.degraded : series.restored).Increment();
}

void Metrics::link(TenantId tenant, const LinkReport& report) { families_->links.count(tenant, report); }

void Metrics::refused(TenantId tenant, std::string_view limit) {
  const prometheus::Labels labels{{"tenant", families_->names[tenant.value]}, {"limit", std::string(limit)}};
  families_->limit_refusals.Add(labels).Increment();
}

void Metrics::shares(const ShareReport& report) {
  for (size_t i = 0; i < report.tenants.size(); ++i) {
    const TenantReport& tenant = report.tenants[i];
    TenantSeries& series = *families_->tenants[i];
    series.share.Set(tenant.share);
    series.expected_share.Set(tenant.expected_share);
    series.lag.Set(to_seconds(tenant.lag));
    series.cost_error.Set(tenant.predicted_error);
  }
  families_->jain.Set(report.jain);
  families_->worst_lag.Set(to_seconds(report.worst_lag));
}

void Metrics::scene_resident(const std::string& scene, const scenes::LoadedScene& loaded,
                             const gpu::SceneFootprint& on_device) {
  if (!families_->tenants.front()->scenes.contains(scene)) return;
  const prometheus::Labels labels{{"scene", scene}};
  families_->resident.Add(labels).Set(1);
  families_->load_seconds.Add(labels).Set(loaded.load_seconds);
  families_->build_seconds.Add(labels).Set(on_device.tracer_build_seconds);
  families_->scene_bytes.Add(labels).Set(static_cast<double>(loaded.memory_bytes));
  families_->device_bytes.Add(labels).Set(static_cast<double>(on_device.memory_bytes));
  families_->tracer_bytes.Add(labels).Set(static_cast<double>(on_device.tracer_memory_bytes));
  families_->from_cache.Add(labels).Set(on_device.tracer_from_cache ? 1 : 0);
  families_->average_list.Add(labels).Set(on_device.tracer_average_list);
  families_->longest_list.Add(labels).Set(on_device.tracer_longest_list);
}

void Metrics::scene_unloaded(const std::string& scene) {
  if (!families_->tenants.front()->scenes.contains(scene)) return;
  const prometheus::Labels labels{{"scene", scene}};
  for (auto* family :
       {&families_->resident, &families_->scene_bytes, &families_->device_bytes, &families_->tracer_bytes}) {
    family->Add(labels).Set(0);
  }
}

void Metrics::scene_lights(const std::string& scene, const gpu::LightState& lights) {
  if (!families_->tenants.front()->scenes.contains(scene)) return;
  families_->lights.Add({{"scene", scene}, {"state", "resting"}}).Set(lights.resting);
  families_->lights.Add({{"scene", scene}, {"state", "moving"}}).Set(lights.moving);
  families_->rebuilds.Add({{"scene", scene}});
}

void Metrics::lights_rebuilt(const std::string& scene) {
  if (!families_->tenants.front()->scenes.contains(scene)) return;
  families_->rebuilds.Add({{"scene", scene}}).Increment();
}

uint64_t Metrics::count_of(Fault fault) const {
  return static_cast<uint64_t>(families_->faults[static_cast<size_t>(fault)]->Value());
}

std::string Metrics::text() const { return prometheus::TextSerializer().Serialize(families_->registry.Collect()); }

}  // namespace gnomon::daemon
