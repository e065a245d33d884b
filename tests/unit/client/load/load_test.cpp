// gnomon-load's parts, and its clients against a scripted server.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "client/cli/options.h"
#include "client/load/load_plan.h"
#include "client/load/load_report.h"
#include "client/load/load_run.h"
#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

TEST(LoadPlan, SplitsClientsAmongTenants) {
  const fs::path token = fs::temp_directory_path() / ("gnomon-token-" + std::to_string(getpid()));
  std::ofstream(token) << "secret\n";
  auto plan = plan_load({"studio:" + token.string() + ":2", "arcade::6"}, 8);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_TRUE(read_tokens(*plan));
  fs::remove(token);
  ASSERT_EQ(plan->size(), 2u);
  EXPECT_EQ((*plan)[0].tenant, "studio");
  EXPECT_EQ((*plan)[0].token, "secret");
  EXPECT_EQ((*plan)[0].clients, 2u);
  EXPECT_EQ((*plan)[1].token, "");
  EXPECT_EQ(plan_load({}, 5)->front().clients, 5u);
}

TEST(LoadPlan, RefusesWhatDoesNotAddUp) {
  EXPECT_FALSE(plan_load({}, 0));
  EXPECT_EQ(plan_load({"a::3"}, 4).error().message, "--clients 4 but the tenants have 3");
  auto unreadable = plan_load({"a:/no/such/file:3"}, 0);
  EXPECT_FALSE(read_tokens(*unreadable));
  for (const char* text : {"", "a", "a:3", "::3", "a::0", "a::x", "a::3x"}) EXPECT_FALSE(parse_group(text)) << text;
}

TEST(LoadPlan, ASweepDoublesAndEndsWithTheLast) {
  EXPECT_EQ(*parse_clients("8"), (std::vector<size_t>{8}));
  EXPECT_EQ(*parse_clients("1..64"), (std::vector<size_t>{1, 2, 4, 8, 16, 32, 64}));
  EXPECT_EQ(*parse_clients("3..7"), (std::vector<size_t>{3, 6, 7}));
  for (const char* text : {"", "0", "x", "8x", "1..", "..8", "8..1", "0..4", "1..2..4", "-1", "1..999999"}) {
    EXPECT_FALSE(parse_clients(text)) << text;
  }
}

// 10 cameras: 6 answered, 3 replaced by newer ones, 1 without any answer.
LoadRow some_row() {
  LoadRow row;
  row.figures.counters.asked = 10;
  row.figures.counters.complete = 5;
  row.figures.counters.incomplete = 1;
  row.figures.pending = 1;
  row.figures.times = {
      .answers = 6, .response = 600ms, .server = 300ms, .device = 120ms, .known = 90ms, .queue = 30ms};
  return row;
}

TEST(LoadFigures, EveryCameraIsAnsweredCoalescedOrDropped) {
  const LoadRow row = some_row();
  EXPECT_EQ(row.figures.coalesced(), 3u);
  EXPECT_EQ(row.figures.dropped(), 1u);
  EXPECT_EQ(without_answer(row, 0),
            "4 of 10 cameras stayed without an answer (40.0%): 3 were coalesced, a newer one was answered in their "
            "place, and 1 dropped");
  EXPECT_NE(without_answer(row, 0.39), "");
  EXPECT_EQ(without_answer(row, 0.4), "");
}

TEST(LoadFigures, TheMeanAnswersTimeIsTheSumOfItsStages) {
  const StageTimes times = some_row().figures.times;
  EXPECT_DOUBLE_EQ(times.response_ms(), 100);
  EXPECT_DOUBLE_EQ(times.queue_ms() + times.device_ms() + times.encode_ms() + times.network_ms(), 100);
  EXPECT_EQ(
      load_remarks(some_row()).front(),
      "the mean answer took 100.0 ms: queue 10.0, device 20.0, encoding and sending 20.0, network and client 50.0");
}

TEST(LoadFigures, WhatStatsSayOfAnotherSecondMovesNoOtherStage) {
  StageTimes times{.answers = 2, .response = 100ms, .server = 80ms, .device = 20ms};
  times.take_queue({}, 500ms);  // of a second that was slower than these answers
  EXPECT_DOUBLE_EQ(times.queue_ms(), 30);
  EXPECT_DOUBLE_EQ(times.encode_ms(), 0);
  const StageTimes before = times;
  times += {.answers = 2, .response = 100ms, .server = 80ms, .device = 20ms};
  times.take_queue(before, 10ms);
  EXPECT_DOUBLE_EQ(times.queue_ms(), 20);
  EXPECT_DOUBLE_EQ(times.queue_ms() + times.device_ms() + times.encode_ms() + times.network_ms(),
                   times.response_ms());
}

TEST(LoadFigures, CsvHasALineForEachRowAndQuotesWhatNeedsIt) {
  const fs::path file = fs::temp_directory_path() / ("gnomon-csv-" + std::to_string(getpid()));
  Report report;
  report.rows.push_back({{"scope", "client"}, {"tenant", "a,\"b\""}, {"vbps", 1.5}});
  report.rows.push_back({{"scope", "total"}, {"vbps", 2}});
  ASSERT_TRUE(write_csv(file, report));
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  fs::remove(file);
  EXPECT_EQ(text.str(), "scope,tenant,vbps\nclient,\"a,\"\"b\"\"\",1.5\ntotal,,2\n");
}

TEST(Options, SizesAreCheckedAgainstWhatTheWireCarries) {
  EXPECT_EQ(parse_size("1920x1080")->width, 1920);
  EXPECT_EQ(parse_size("1920x1080")->height, 1080);
  EXPECT_EQ(parse_size("0x36", 0)->width, 0);
  for (const char* text : {"", "x", "10", "10x", "x10", "0x10", "10x7681", "-1x5", "10x10x10", "1e3x10"}) {
    EXPECT_FALSE(parse_size(text)) << text;
  }
}

TEST(LoadRun, CountsWhatTheServerAnswered) {
  const TileGrid grid{64, 48, 2};
  const auto mask = tests::noise(grid, 4);
  tests::FakeServer server([&](tests::Peer& peer) {
    peer.read();
    peer.welcome(tests::small_welcome(64, 48, 2));
    for (int i = 0; i < 20; ++i) {
      const auto camera = peer.read_new_camera();
      if (!camera) return;
      peer.send_frame(camera->frame, mask.view());
    }
    peer.read_new_camera();  // when it arrives, the last answer has been counted
  });
  const LoadOptions options{.server = server.address(),
                            .trust = tests::FakeServer::trust(),
                            .scene = "none",
                            .scene_folder = {},
                            .size = {64, 48},
                            .rate_hz = 0,
                            .duration = 30s};
  LoadRun run(options, *plan_load({}, 1));
  Progress progress;
  const auto done = run.run(progress);
  ASSERT_TRUE(done) << done.error().message;
  const auto rows = load_rows(run);
  ASSERT_EQ(rows.size(), 3u);
  for (const auto& row : rows) {
    EXPECT_EQ(row.figures.counters.complete, 20u);
    EXPECT_EQ(row.figures.counters.invalid_slices, 0u);
    EXPECT_EQ(row.figures.latencies.count(), 20u);
    EXPECT_EQ(row.figures.offered(), 21u);
    EXPECT_EQ(row.figures.answered(), 20u);
    EXPECT_EQ(row.figures.coalesced(), 0u);
    EXPECT_EQ(row.figures.dropped(), 1u) << "the server left before it answered the last";
    EXPECT_GT(row.vbps, 0);
    EXPECT_GT(row.figures.bytes_per_frame(), 64 * 48 * 2 / 8) << "noise does not compress";
  }
  EXPECT_NE(rows[0].error, "") << "the server ended the session early";

  const Report report = load_report(options, run, rows);
  EXPECT_EQ(report.suite, "load");
  EXPECT_EQ(report.driver, "fake");
  EXPECT_EQ(report.device, "fake");
  EXPECT_EQ(report.server, to_string(server.address()));
  EXPECT_EQ(device_of("light_buffer on llvmpipe (LLVM 15.0.6, 256 bits)"), "llvmpipe (LLVM 15.0.6, 256 bits)");
  ASSERT_EQ(report.rows.size(), 3u);
  EXPECT_EQ(report.rows[0]["scope"], "client");
  EXPECT_EQ(report.rows[1]["scope"], "tenant");
  EXPECT_EQ(report.rows[2]["scope"], "total");
  for (const char* key :
       {"vbps", "p50_ms", "p90_ms", "p99_ms", "p999_ms", "bytes_per_frame", "lost_slices", "frames",
        "invalid_slices", "wrong_frames", "offered", "answered", "coalesced", "dropped", "mean_network_ms"}) {
    for (const auto& row : report.rows) EXPECT_TRUE(row.contains(key) && row[key].is_number()) << key;
  }
}

TEST(LoadRun, NobodyThereIsAnError) {
  Address address;
  {
    tests::FakeServer server([](tests::Peer& peer) { peer.hang_up(); });
    address = server.address();
    Loop loop;
    StreamOptions options;
    options.connect.server = address;
    VisibilityStream first(loop, options, {});
    EXPECT_FALSE(first.wait_open());
  }
  LoadRun run({.server = address,
               .trust = tests::FakeServer::trust(),
               .scene = "none",
               .scene_folder = {},
               .size = {64, 48}},
              *plan_load({}, 3));
  Progress progress;
  const auto done = run.run(progress);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("cannot reach"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::client
