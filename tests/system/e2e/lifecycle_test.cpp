// gnomond's beginning and end: what it refuses to start with, and how it goes.
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"

namespace gnomon::tests {
namespace {

namespace fs = std::filesystem;

TEST(Lifecycle, DrainsOnSigtermAndExitsZero) {
  Daemon daemon;
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path()));
  ASSERT_TRUE(all_progress(loop, fliers, 2));
  daemon.process().signal(SIGTERM);
  EXPECT_TRUE(loop.run_until(Clock::now() + kPatience, [&] {
    return fliers[0]->stream().connection().failure().has_value() || fliers[0]->told_of_draining();
  }));
  EXPECT_TRUE(fliers[0]->told_of_draining()) << "clients are told before they are closed";
  EXPECT_TRUE(loop.run_until(Clock::now() + kPatience, [&] {
    return fliers[0]->stream().connection().failure().has_value();
  })) << "a client that stays is closed at the deadline";
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.process().output();
}

TEST(Lifecycle, GoesAtOnceWhenNobodyIsThere) {
  Daemon daemon;
  daemon.process().signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.process().output();
}

// The daemon gives it up while it sleeps; its keys are gone then.
TEST(ClientProgram, FindsItsServerAgainAfterASleep) {
  const Daemon daemon;
  const TemporaryFolder folder;
  const fs::path json = folder.path() / "client.json";
  Process sleeper(
      "gnomon-client",
      {"--server", daemon.server(), "--pin", daemon.pin(), "--tenant", "studio", "--scene", "living_room", "--size",
       "64x36", "--mode", "predicted", "--rate", "20", "--frames", "60", "--json", json.string()},
      folder.path());
  ASSERT_TRUE(eventually([&] { return daemon.sessions() == 1; }));
  sleeper.signal(SIGSTOP);
  EXPECT_TRUE(eventually([&] { return daemon.sessions() == 0; }));
  sleeper.signal(SIGCONT);
  ASSERT_EQ(sleeper.wait(), 0) << sleeper.output();
  EXPECT_EQ(nlohmann::json::parse(read_file(json))["rows"][0]["reconnects"], 1);
}

TEST(Reload, OverHttpTakesWhatIsGoodAndSaysWhatIsWrong) {
  Daemon daemon;
  daemon.rewrite_config(std::string(kConfig) + "scheduler: {policy: priority}\n");
  EXPECT_NE(daemon.post("/reload", "{}").find(" 200 "), std::string::npos);
  EXPECT_TRUE(
      eventually([&] { return daemon.page("/status").find("\"policy\": \"priority\"") != std::string::npos; }));
  daemon.rewrite_config(std::string(kConfig) + "scheduler: {policy: fairest}\n");
  EXPECT_NE(daemon.post("/reload", "{}").find(" 409 "), std::string::npos);
  EXPECT_NE(daemon.process().output().find("scheduler.policy"), std::string::npos) << "the log says why";
  EXPECT_NE(daemon.page("/status").find("\"policy\": \"priority\""), std::string::npos);
  EXPECT_EQ(daemon.metric("gnomon_config_reloads_total", {"failed"}), 1);
}

TEST(CheckConfig, TakesGoodFilesAndNamesFileLineAndKeyOfBadOnes) {
  const TemporaryFolder folder;
  const fs::path good = folder.path() / "good.yaml";
  std::ofstream(good) << kConfig;
  const auto [good_status, good_output] = run("gnomond", {"--config", good.string(), "--check-config"});
  EXPECT_EQ(good_status, 0) << good_output;

  const fs::path bad = folder.path() / "bad.yaml";
  for (const auto& [text, key] :
       std::vector<std::pair<std::string, std::string>>{{"server:\n  control_prot: 7600\n", "control_prot"},
                                                        {"server:\n  control_port: many\n", "control_port"},
                                                        {"server:\n  control_port: 70000\n", "control_port"},
                                                        {"scheduler:\n  policy: whoever\n", "policy"}}) {
    std::ofstream(bad) << text;
    const auto [status, output] = run("gnomond", {"--config", bad.string(), "--check-config"});
    EXPECT_EQ(status, 1);
    EXPECT_NE(output.find("bad.yaml:2"), std::string::npos) << output;
    EXPECT_NE(output.find(key), std::string::npos) << output;
  }
}

TEST(CheckScene, SaysWhatAGoodFileHoldsAndWhyABadOneIsRefused) {
  const auto good = run("gnomond", {"--check-scene", living_room_file().string()});
  EXPECT_EQ(good.status, 0);
  for (const char* word : {"triangles", "instances", "lights", "hash"}) {
    EXPECT_NE(good.output.find(word), std::string::npos) << good.output;
  }
  const TemporaryFolder folder;
  const std::string whole = read_file(living_room_file());
  ASSERT_GT(whole.size(), 100000u);
  for (const size_t length : {size_t{0}, size_t{11}, size_t{1000}, whole.size() / 2, whole.size() - 1}) {
    const fs::path cut = folder.path() / "cut.glb";
    std::ofstream(cut, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
    const auto [status, output] = run("gnomond", {"--check-scene", cut.string()});
    EXPECT_EQ(status, 1) << length << " bytes: " << output;
    EXPECT_NE(output.find("cut.glb"), std::string::npos) << output;
  }
  EXPECT_EQ(run("gnomond", {"--check-scene", (folder.path() / "none.glb").string()}).status, 1);
}

}  // namespace
}  // namespace gnomon::tests
