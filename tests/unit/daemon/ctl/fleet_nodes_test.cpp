// Which nodes gnomonctl asks, and what it shows of those that answer and those that do not.
#include "daemon/ctl/fleet_nodes.h"

#include <gtest/gtest.h>

#include <fstream>

namespace gnomon::ctl {
namespace {

std::string names_in(const std::string& text) {
  const auto nodes = fleet_nodes(text);
  if (!nodes) return "error: " + nodes.error().message;
  std::string names;
  for (const FleetNode& node : *nodes) names += node.name + " at " + node.address + ";";
  return names;
}

std::string file_of(const std::string& text) {
  const std::string path = testing::TempDir() + "fleet_nodes";
  std::ofstream(path) << text;
  return path;
}

TEST(FleetNodes, AreNamedInWordsOrInAFile) {
  const std::string both = "n1 at https://10.0.0.11:7601;n2 at unix:/run/n2.sock;";
  EXPECT_EQ(names_in("n1=https://10.0.0.11:7601,n2=unix:/run/n2.sock"), both);
  EXPECT_EQ(names_in(file_of("# our nodes\nn1 https://10.0.0.11:7601\n\n  n2\tunix:/run/n2.sock # beside us\n")),
            both);
}

TEST(FleetNodes, WhatIsNoneIsNamed) {
  EXPECT_TRUE(names_in("n1=https://10.0.0.11:7601,n2").starts_with("error: 'n2' is no node"));
  EXPECT_TRUE(names_in("=unix:/run/n.sock").starts_with("error: '=unix:/run/n.sock' is no node"));
  EXPECT_TRUE(names_in("n1=10.0.0.11").starts_with("error: n1: "));
  EXPECT_EQ(names_in("n1=unix:/a,n1=unix:/b"), "error: a second node named n1");
  EXPECT_EQ(names_in("/nowhere/at/all"), "error: /nowhere/at/all: cannot be read");
  const std::string wrong = file_of("n1 unix:/a\nn2\n"), empty = file_of("# nobody\n");
  EXPECT_EQ(names_in(file_of("n1 unix:/a\nn2\n")), "error: " + wrong + ":2: allowed: NAME ADDRESS");
  EXPECT_EQ(names_in(file_of("# nobody\n")), "error: " + empty + ": it names no node");
}

TEST(FleetNodes, OneIsFoundByItsName) {
  const auto nodes = fleet_nodes("n1=unix:/a,n2=unix:/b").value();
  EXPECT_EQ(node_named(nodes, "n2").value().address, "unix:/b");
  EXPECT_EQ(node_named(nodes, "n3").error().message, "no node n3; there are: n1, n2");
  EXPECT_EQ(node_named(nodes, "").error().message, "of a fleet one node is named (--node); there are: n1, n2");
}

TEST(FleetNodes, ThoseThatDoNotAnswerAreShownToo) {
  const nlohmann::json status{
      {"version", "0.1.0"},
      {"ready", true},
      {"devices", {{{"up", true}, {"load", 0.5}}, {{"up", true}, {"load", 0.25}}, {{"up", false}, {"load", 0.0}}}},
      {"scenes", {{{"name", "temple"}}}},
      {"sessions", {{{"id", "1"}}, {{"id", "2"}}}}};
  const std::vector<NodeStatus> fleet{{"n1", status}, {"n2", Error{"no such host"}}};
  const std::string shown = fleet_text(fleet);
  EXPECT_NE(shown.find("37.5%"), std::string::npos) << shown;
  EXPECT_NE(shown.find("does not answer"), std::string::npos) << shown;
  const auto json = fleet_json(fleet);
  EXPECT_EQ(json.at(0).at("status"), status);
  EXPECT_EQ(json.at(1), (nlohmann::json{{"node", "n2"}, {"error", "no such host"}}));
}

TEST(FleetNodes, OfEveryLightTheNewestChangeIsKept) {
  const auto light = [](const char* scene, int number, int at, bool on) {
    return nlohmann::json{{"scene", scene}, {"light", number}, {"at_ms", at}, {"change", {{"on", on}}}};
  };
  const nlohmann::json one{{"lights", {light("temple", 0, 5, false), light("temple", 1, 5, false)}}},
      other{{"lights", {light("temple", 0, 6, true), light("temple", 1, 4, true), light("attic", 0, 1, false)}}};
  const nlohmann::json newest{
      {"lights", {light("attic", 0, 1, false), light("temple", 0, 6, true), light("temple", 1, 5, false)}}};
  EXPECT_EQ(newest_lights({one, other}), newest);
  EXPECT_EQ(newest_lights({other, one}), newest) << "in whatever order they answer";
  EXPECT_EQ(newest_lights({{{"lights", nlohmann::json::array()}}}).dump(), R"({"lights":[]})");
}

TEST(FleetNodes, AllAreAskedAndEachAnswersForItself) {
  const auto nodes = fleet_nodes("n1=unix:/nowhere/one,n2=unix:/nowhere/two").value();
  const auto fleet = status_of(nodes, {});
  ASSERT_EQ(fleet.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(fleet[i].name, nodes[i].name);
    ASSERT_FALSE(fleet[i].status);
    EXPECT_TRUE(fleet[i].status.error().message.starts_with(nodes[i].address)) << fleet[i].status.error().message;
  }
}

}  // namespace
}  // namespace gnomon::ctl
