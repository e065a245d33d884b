#include "daemon/metrics/metrics.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "tests/unit/daemon/net/served.h"

// Included after served.h, as this header and Asio's both declare the system's socket names.
#include <httplib.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

std::map<std::string, std::string> types_in(const std::string& text) {
  std::map<std::string, std::string> types;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string hash, type, name, kind;
    words >> hash >> type >> name >> kind;
    if (hash == "#" && type == "TYPE") types[name] = kind;
  }
  return types;
}

TEST(Metrics, FollowPrometheusNamingRules) {
  const Metrics metrics({"default"}, {"room"}, "1.2.3");
  const auto types = types_in(metrics.text());
  EXPECT_GE(types.size(), 10u);
  for (const auto& [name, type] : types) {
    EXPECT_TRUE(name.starts_with("gnomon_") || name.starts_with("process_")) << name;
    EXPECT_EQ(name.ends_with("_total"), type == "counter") << name;
    for (const char* unit : {"_ms", "_us", "_ns", "_milliseconds", "_kb", "_percent"}) {
      EXPECT_EQ(name.find(unit), std::string::npos) << name << " is not in base units";
    }
    EXPECT_NE(metrics.text().find("# HELP " + name + " "), std::string::npos) << name;
  }
}

TEST(Metrics, TheProcessIsDescribedUnderTheUsualNames) {
  const Metrics metrics({"default"}, {}, "test");
  const std::string text = metrics.text();
  const auto value_of = [&](const std::string& name) {
    const size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::stod(text.substr(at + name.size() + 2));
  };
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  EXPECT_GT(value_of("process_start_time_seconds"), now.count() - 600) << "this test was started just now";
  EXPECT_LE(value_of("process_start_time_seconds"), now.count());
  EXPECT_GE(value_of("process_cpu_seconds_total"), 0);
  EXPECT_GE(value_of("process_threads"), 1);
  EXPECT_GE(value_of("process_open_fds"), 3);
  EXPECT_GT(value_of("process_max_fds"), value_of("process_open_fds"));
  EXPECT_GT(value_of("process_resident_memory_bytes"), 1e6);
  EXPECT_GT(value_of("process_virtual_memory_bytes"), value_of("process_resident_memory_bytes"));
  EXPECT_EQ(value_of("gnomon_process_resident_memory_bytes"), value_of("process_resident_memory_bytes"));
}

// Of any time from 0.1 ms to 0.8 s, the bucket that it is counted in tells it but for a factor of two.
TEST(Metrics, BucketsBoundTheErrorOfAQuantile) {
  const Metrics metrics({"default"}, {"room"}, "test");
  const std::string text = metrics.text();
  const std::string family = "gnomon_frame_seconds_bucket{";
  double below = 0, first = 0, last = 0;
  for (size_t at = 0; (at = text.find("\n" + family, at)) != std::string::npos; ++at) {
    const size_t le = text.find("le=\"", at) + 4;
    if (text.compare(le, 4, "+Inf") == 0) continue;
    const double bound = std::stod(text.substr(le));
    EXPECT_LE(bound, below > 0 ? 2.0001 * below : 1e-4);
    first = first == 0 ? bound : first;
    last = below = bound;
  }
  EXPECT_LE(first, 1e-4);
  EXPECT_GE(last, 0.8);
}

TEST(Metrics, EveryFaultHasItsOwnSeries) {
  Metrics metrics({"default"}, {}, "test");
  std::set<std::pair<FaultKind, std::string>> labels;
  for (const FaultRow& row : fault_table()) {
    EXPECT_TRUE(labels.insert({row.kind, row.label}).second) << row.label << " twice";
    metrics.report(row.fault);
    EXPECT_EQ(metrics.count_of(row.fault), 1u) << row.label;
    EXPECT_NE(metrics.text().find(std::string("{reason=\"") + row.label + "\"} 1"), std::string::npos) << row.label;
  }
}

TEST(Metrics, WhatIsLoggedOfASessionSaysWhose) {
  Metrics metrics({"lab", "hall"}, {}, "test");
  testing::internal::CaptureStderr();
  metrics.dropped(TenantId{1}, SessionId{42}, Fault::encode_failed, "no reason");
  metrics.report(TenantId{0}, SessionId{43}, Fault::device_lost);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("frame could not be encoded session=42 tenant=hall why=\"no reason\""), std::string::npos)
      << log;
  EXPECT_NE(log.find("frame lost with the device session=43 tenant=lab\n"), std::string::npos) << log;
}

TEST(Metrics, AFrameIsCountedOnceInEveryStage) {
  Metrics metrics({"lab", "hall"}, {"room"}, "test");
  FrameMeta meta;
  meta.spec.grid = {100, 50, 3};
  meta.spec.traced_bits = 15'000;
  meta.times.arrival = TimePoint(1h);
  meta.times.submitted = meta.times.arrival + 1ms;
  meta.times.gpu = 5ms;
  meta.times.readback = 2ms;
  meta.times.encode_began = meta.times.arrival + 7ms;
  meta.times.encoded = meta.times.arrival + 9ms;
  metrics.frame_sent(TenantId{1}, "room", meta, meta.times.arrival + 10ms, 1234);
  metrics.frame_sent(TenantId{1}, "some/file.glb", meta, meta.times.arrival + 10ms, 1);
  const std::string text = metrics.text();
  // The value of the series with this name and these labels, in any order.
  const auto value_of = [&](const std::string& name, const std::vector<std::string>& labels) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      const bool here = line.starts_with(name + "{") &&
                        std::all_of(labels.begin(), labels.end(),
                                    [&](const auto& l) { return line.find("\"" + l + "\"") != std::string::npos; });
      if (here) return std::stod(line.substr(line.rfind(' ')));
    }
    return -1.0;
  };
  EXPECT_EQ(value_of("gnomon_visibility_values_total", {"hall"}), 30000);
  EXPECT_EQ(value_of("gnomon_visibility_buffers_total", {"hall"}), 2);
  EXPECT_EQ(value_of("gnomon_visibility_buffers_total", {"lab"}), 0);
  EXPECT_EQ(value_of("gnomon_scene_visibility_buffers_total", {"room"}), 1);
  EXPECT_EQ(value_of("gnomon_scene_visibility_buffers_total", {"other"}), 1);
  EXPECT_EQ(value_of("gnomon_frame_seconds_count", {"hall"}), 2);
  EXPECT_NEAR(value_of("gnomon_frame_seconds_sum", {"hall"}), 0.02, 1e-9);
  EXPECT_EQ(value_of("gnomon_bytes_sent_total", {"hall"}), 1235);
  const std::map<std::string, double> seconds{
      {"queue", 0.001}, {"gpu", 0.003}, {"readback", 0.002}, {"encode", 0.002}, {"send", 0.001}};
  for (const auto& [stage, each] : seconds) {
    EXPECT_EQ(value_of("gnomon_stage_seconds_count", {stage}), 2) << stage;
    EXPECT_NEAR(value_of("gnomon_stage_seconds_sum", {stage}), 2 * each, 1e-9) << stage;
  }
}

TEST(Metrics, LinksAreSummedUp) {
  Metrics metrics({"default"}, {}, "test");
  LinkReport report;
  report.counted = {.sent = 100, .arrived = 90, .lost = 10, .retransmitted = 8, .parity = 5, .recovered = 2};
  report.rate = 1.5e6;
  report.rtt = 30ms;
  report.queue = 3ms;
  metrics.links().count(report);
  metrics.links().count({.counted = {.sent = 1}});  // without a round-trip time no histogram is updated
  const std::string text = metrics.text();
  for (const char* line : {"gnomon_datagrams_sent_total 101", "gnomon_datagrams_lost_total 10",
                           "gnomon_datagrams_retransmitted_total 8", "gnomon_datagrams_parity_total 5",
                           "gnomon_slices_recovered_total 2", "gnomon_link_rate_bytes_per_second_sum 1500000",
                           "gnomon_link_rtt_seconds_count 1", "gnomon_link_queue_seconds_bucket{le=\"0.005\"} 1"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line;
  }
}

TEST(Metrics, AScenesLightBuffersAreDescribed) {
  Metrics metrics({"default"}, {"room"}, "test");
  gpu::SceneFootprint on_device;
  on_device.memory_bytes = 5000;
  on_device.tracer_memory_bytes = 3000;
  on_device.tracer_build_seconds = 1.5;
  on_device.tracer_from_cache = true;
  metrics.scenes().resident("room", {}, on_device);
  metrics.scenes().resident("some/file.glb", {}, on_device);
  for (const char* scene : {"room", "some/file.glb"}) {
    SceneReport built{scene, on_device, {0, 0, 2}, {{1.0f, 0.5f}}};
    metrics.scenes().lights(scene, built.lights);
    metrics.scenes().built(built);
  }
  const std::string text = metrics.text();
  for (const char* line :
       {"gnomon_scene_device_memory_bytes{scene=\"room\"} 5000",
        "gnomon_scene_tracer_memory_bytes{scene=\"room\"} 3000", "gnomon_scene_build_seconds{scene=\"room\"} 1.5",
        "gnomon_scene_light_buffer_cached{scene=\"room\"} 1", "gnomon_scene_light_buffer_kept{scene=\"room\"} 1",
        "gnomon_scene_light_buffers_built_ratio{scene=\"room\"} 0.75",
        "gnomon_scene_lights{scene=\"room\",state=\"unbuilt\"} 2"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line;
  }
  EXPECT_EQ(text.find("some/file.glb"), std::string::npos);
}

using AdminPages = Served;

TEST_F(Served, RefusesToStartWithASceneWithoutLights) {
  write_scene(folder_ / "night.gltf", false);
  config_.scenes.list.push_back({"night", folder_ / "night.gltf", "gnomond.yaml:7"});
  Daemon::Options options;
  options.config = config_;
  options.make_renderers = {[]() -> Result<std::unique_ptr<gpu::Renderer>> {
    return std::unique_ptr<gpu::Renderer>(std::make_unique<SelfRunningFakeRenderer>(1, 0, 0ms));
  }};
  const auto daemon = Daemon::start(std::move(options));
  ASSERT_FALSE(daemon);
  EXPECT_EQ(daemon.error().message, "gnomond.yaml:7: scene night: it has no lights: there is nothing to trace");
}

TEST_F(AdminPages, AnswerWhatOperatorsAskAndClientsAreToldTheirShareOfIt) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  c.send_view(1, 1);
  ASSERT_FALSE(c.receive_frame(1).empty());

  httplib::Client http("127.0.0.1", daemon_->admin().port());
  EXPECT_EQ(http.Get("/healthz")->status, 200);
  EXPECT_EQ(http.Get("/readyz")->status, 200);
  EXPECT_EQ(http.Get("/nothing")->status, 404);
  EXPECT_NE(http.Get("/metrics")->body.find("gnomon_build_info{version=\"test\"} 1"), std::string::npos);
  protocol::Stats stats;
  while (stats.frames < 1) {
    const auto next = c.receive_a<protocol::Stats>();
    ASSERT_TRUE(next);
    stats = *next;
  }
  EXPECT_EQ(stats, (protocol::Stats{1, 0, stats.queue_us, stats.gpu_us, stats.total_us}));
  std::string status;
  ASSERT_TRUE(eventually([&] {
    status = http.Get("/status")->body;
    return status.find("\"frames\": 1") != std::string::npos;
  })) << status;
  for (const char* part : {"\"ready\": true", "\"name\": \"triangle\"", "\"name\": \"fake\"",
                           "\"tenant\": \"default\"", "\"width\": 32", "\"total_us\""}) {
    EXPECT_NE(status.find(part), std::string::npos) << part << " is not in\n" << status;
  }
}

TEST_F(AdminPages, SayNotReadyWhileStopping) {
  config_.server.drain_timeout = 30s;
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  std::thread draining([&] { daemon_->drain(); });
  ASSERT_TRUE(c.receive_a<protocol::Draining>());
  httplib::Client http("127.0.0.1", daemon_->admin().port());
  EXPECT_EQ(http.Get("/readyz")->status, 503);
  EXPECT_EQ(http.Get("/readyz")->body, "not ready: stopping\n");
  EXPECT_EQ(http.Get("/healthz")->status, 200);
  c.send(protocol::Bye{});
  draining.join();
}

}  // namespace
}  // namespace gnomon::daemon
