// The door's configuration as text. tests/fleet gives it to HAProxy itself.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "daemon/ctl/fleet.h"

namespace gnomon::ctl {
namespace {

std::string made(std::vector<std::string> nodes) {
  const auto text = haproxy_text({.nodes = std::move(nodes)});
  return text ? *text : "error: " + text.error().message;
}

std::string server_line(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  server " + name + " ")) return line;
  return "";
}

TEST(FleetDoor, ANodesLineDependsOnItselfAlone) {
  const std::string three = made({"n1=10.0.0.11", "n2=10.0.0.12:7700", "n3=[2001:db8::3]"});
  EXPECT_NE(server_line(three, "n1").find(" 10.0.0.11:7600 id "), std::string::npos) << three;
  EXPECT_NE(server_line(three, "n2").find(" 10.0.0.12:7700 id "), std::string::npos) << three;
  EXPECT_NE(server_line(three, "n3").find(" [2001:db8::3]:7600 id "), std::string::npos) << three;
  const std::string two = made({"n3=[2001:db8::3]", "n1=10.0.0.11"});
  EXPECT_EQ(server_line(two, "n1"), server_line(three, "n1"));
  EXPECT_EQ(server_line(two, "n3"), server_line(three, "n3"));
}

TEST(FleetDoor, AThousandNodesHaveIdsOfTheirOwn) {
  std::vector<std::string> nodes;
  for (int i = 0; i < 1000; ++i) nodes.push_back("node" + std::to_string(i) + "=10.0.0.1");
  EXPECT_FALSE(made(nodes).starts_with("error")) << made(nodes).substr(0, 200);
}

TEST(FleetDoor, WhatIsNoNodeIsNamed) {
  for (const char* wrong :
       {"", "n1", "=10.0.0.1", "n1=", "n1=10.0.0.1:", "n1=10.0.0.1:0", "n1=10.0.0.1:70000", "n 1=a", "n1=a b",
        "n1=2001:db8::1", "n1=[2001:db8::1", "n1=a\nserver evil 10.0.0.9:1"}) {
    EXPECT_TRUE(made({"n2=10.0.0.2", wrong}).starts_with("error: '" + std::string(wrong) + "' is no node"))
        << wrong;
  }
  EXPECT_EQ(made({"n1=10.0.0.1", "n1=10.0.0.2"}), "error: a second node named n1");
}

TEST(FleetDoor, TheShippedExampleIsWhatIsMade) {
  std::ifstream file(GNOMON_SOURCE_DIR "/deploy/fleet/haproxy.cfg");
  std::stringstream shipped;
  shipped << file.rdbuf();
  EXPECT_EQ(shipped.str(), made({"n1=10.0.0.11", "n2=10.0.0.12", "n3=10.0.0.13"}));
}

}  // namespace
}  // namespace gnomon::ctl
