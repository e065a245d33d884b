// The series behind Metrics: every family with its name and help, and the series that are made at the start. Included
// by metrics.cpp only.
#pragma once

#include <array>
#include <atomic>

#include "daemon/metrics/link_metrics.h"
#include "daemon/metrics/metrics.h"
#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Registry;

// Seconds, from a stage of a fast GPU (0.1 ms) to a frame of an overloaded node (0.82 s). Each bound is twice the one
// before, so that a quantile within them is wrong by less than a factor of two, however long frames take.
inline const Histogram::BucketBoundaries kSecondsBuckets = [] {
  Histogram::BucketBoundaries bounds{0.0001};
  while (bounds.size() < 14) bounds.push_back(2 * bounds.back());
  return bounds;
}();

struct Stages {
  Histogram *queue, *gpu, *readback, *encode, *send;

  explicit Stages(Family<Histogram>& family) {
    const auto stage = [&](const char* name) { return &family.Add({{"stage", name}}, kSecondsBuckets); };
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

struct TenantSeries {
  Histogram& frame;
  Counter& buffers;
  Counter& bits;
  Counter& views;
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

struct Metrics::Families {
  Families(const std::vector<std::string>& scene_names, size_t device_count)
      : scenes(registry, scene_names), devices(registry, device_count) {}

  Registry registry;
  Family<Counter>& buffers = counter_family(registry, "gnomon_visibility_buffers_total",
                                            "Visibility buffers sent; vbps is the rate of this.");
  Family<Counter>& bits = counter_family(registry, "gnomon_visibility_values_total",
                                         "Visibility values sent: pixels times lights, a bit each.");
  Family<Counter>& views =
      counter_family(registry, "gnomon_views_received_total", "Views that sessions asked for, served or not.");
  Family<Counter>& coalesced = counter_family(registry, "gnomon_frames_coalesced_total",
                                              "Views replaced by a newer one before they were rendered.");
  Family<Counter>& bytes =
      counter_family(registry, "gnomon_bytes_sent_total", "Bytes of datagrams sent to clients.");
  Family<Counter>& codec_bytes =
      counter_family(registry, "gnomon_codec_bytes_sent_total", "Bytes of frames sent to clients, by codec.");
  Family<Counter>& dropped =
      counter_family(registry, "gnomon_frames_dropped_total", "Views and frames dropped, by reason.");
  Counter& datagrams =
      counter_family(registry, "gnomon_datagrams_received_total", "Datagrams received, good or not.").Add({});
  Family<Counter>& rejected = counter_family(registry, "gnomon_datagrams_rejected_total",
                                             "Datagrams that were not a view of a session, by reason.");
  Family<Counter>& refusals =
      counter_family(registry, "gnomon_refusals_total", "Connections that got no session, by reason.");
  Family<Counter>& admin_closed = counter_family(registry, "gnomon_admin_connections_closed_total",
                                                 "Admin connections closed before they had asked, by reason.");
  Family<Counter>& admin_refused = counter_family(registry, "gnomon_admin_refusals_total",
                                                  "Requests refused by the admin server over TCP, by reason.");
  Family<Counter>& queue_seconds = counter_family(
      registry, "gnomon_tenant_queue_seconds_total",
      "Time that the tenant's frames waited from their camera's arrival to their start; divide by buffers.");
  Family<Counter>& gpu_seconds =
      counter_family(registry, "gnomon_tenant_gpu_seconds_total", "Device time that the tenant's frames took.");
  Family<Counter>& late =
      counter_family(registry, "gnomon_frames_late_total",
                     "Frames that were sent, or given up, after the time until which they were of use.");
  // These series are made when there is something to count, as most tenants never lose a frame.
  Family<Counter>& tenant_dropped = counter_family(registry, "gnomon_tenant_frames_dropped_total",
                                                   "Views and frames of the tenant that were dropped, by reason.");
  Family<Counter>& degradations = counter_family(
      registry, "gnomon_degradations_total", "Steps down and up of sessions that the device did not keep up with.");
  Counter& degraded = degradations.Add({{"direction", "down"}});
  Counter& restored = degradations.Add({{"direction", "up"}});
  Family<Gauge>& share = gauge_family(registry, "gnomon_tenant_share_ratio",
                                      "The tenant's part of the device time of the last second.");
  Family<Gauge>& expected_share = gauge_family(registry, "gnomon_tenant_expected_share_ratio",
                                               "Its part by weight, if it had work all through the last second.");
  Family<Gauge>& lag =
      gauge_family(registry, "gnomon_tenant_lag_seconds",
                   "Device time that the policy owes the tenant; negative: it had some in advance.");
  Gauge& cost_error = gauge_family(registry, "gnomon_cost_error_ratio",
                                   "Mean error of predicted costs, relative to real ones, in the last second.")
                          .Add({});
  Gauge& jain =
      gauge_family(registry, "gnomon_fairness_jain_index",
                   "Jain's index of device time by weight, of the tenants that always had work: 1 is fair.")
          .Add({});
  Gauge& worst_lag =
      gauge_family(registry, "gnomon_fairness_worst_lag_seconds", "The largest lag of any tenant, either way.")
          .Add({});
  Family<Gauge>& sessions = gauge_family(registry, "gnomon_sessions", "Open sessions.");
  Family<Gauge>& build = gauge_family(registry, "gnomon_build_info", "Always 1; the version is the label.");
  Family<Histogram>& stages =
      histogram_family(registry, "gnomon_stage_seconds", "Time that frames of all tenants spent in a stage.");
  Stages stage{stages};
  Family<Histogram>& frames =
      histogram_family(registry, "gnomon_frame_seconds", "Time from a camera's arrival until its frame was sent.");

  Family<Counter>& limit_refusals = counter_family(registry, "gnomon_tenant_refusals_total",
                                                   "Sessions refused a tenant, by the limit that they met.");

  std::array<std::atomic<Counter*>, protocol::kCodecNumbers> codecs{};  // by CodecId; nullptr: not used yet
  LinkMetrics links{registry};
  OperationMetrics operation{registry};
  SceneMetrics scenes;
  DeviceMetrics devices;
  // Reserved once: adding a tenant moves no series that other threads may be counting in.
  std::vector<std::string> names;  // of the tenants
  std::vector<std::unique_ptr<TenantSeries>> tenants;
  std::vector<Counter*> faults;  // by Fault; nullptr: made when there is something to count

  Family<Counter>& family_of(FaultKind kind) {
    switch (kind) {
      case FaultKind::datagram_rejected: return rejected;
      case FaultKind::frame_dropped: return dropped;
      case FaultKind::refusal: return refusals;
      case FaultKind::admin_closed: return admin_closed;
      case FaultKind::admin_refused: return admin_refused;
    }
    return dropped;
  }

  // The counter is made when the codec is first used, and kept, so that a frame never waits for a scrape of the family.
  Counter& bytes_of(protocol::CodecId codec) {
    std::atomic<Counter*>& kept = codecs[static_cast<size_t>(codec)];
    if (!kept) kept = &codec_bytes.Add({{"codec", std::string(protocol::to_string(codec))}});
    return *kept;
  }

  Counter& counter_of(const FaultRow& row) { return family_of(row.kind).Add({{"reason", row.label}}); }

  void add_tenant(const std::string& name) {
    const prometheus::Labels tenant{{"tenant", name}};
    auto series = std::make_unique<TenantSeries>(TenantSeries{.frame = frames.Add(tenant, kSecondsBuckets),
                                                              .buffers = buffers.Add(tenant),
                                                              .bits = bits.Add(tenant),
                                                              .views = views.Add(tenant),
                                                              .coalesced = coalesced.Add(tenant),
                                                              .bytes_sent = bytes.Add(tenant),
                                                              .queue_seconds = queue_seconds.Add(tenant),
                                                              .gpu_seconds = gpu_seconds.Add(tenant),
                                                              .late = late.Add(tenant),
                                                              .share = share.Add(tenant),
                                                              .expected_share = expected_share.Add(tenant),
                                                              .lag = lag.Add(tenant),
                                                              .sessions = sessions.Add(tenant)});
    tenants.push_back(std::move(series));
    names.push_back(name);
  }
};

}  // namespace gnomon::daemon
