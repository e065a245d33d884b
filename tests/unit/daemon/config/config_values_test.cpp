// What a reload says it has changed, and where strangers may be served.
#include <gtest/gtest.h>

#include "daemon/config/config.h"

namespace gnomon::daemon {
namespace {

std::string changes(const std::string& before, const std::string& after,
                    const std::vector<std::string>& overrides = {}) {
  const auto old = parse_config(before, "old"), now = parse_config(after, "new", overrides);
  EXPECT_TRUE(old && now);
  std::string all;
  for (const std::string& change : changes_between(old->values, now->values)) {
    all += (all.empty() ? "" : ", ") + change;
  }
  return all;
}

TEST(ConfigChanges, NameTheKeyItsOldValueAndItsNewOne) {
  EXPECT_EQ(changes("server: {max_sessions: 7}", "server: {max_sessions: 8, listen: '::1'}"),
            "server.listen: (default) -> ::1, server.max_sessions: 7 -> 8");
  EXPECT_EQ(changes("log: {level: debug}", "log: {}"), "log.level: debug -> (default)");
  EXPECT_EQ(changes("admin: {token_file: t}", "admin: {token_file: ''}"), "admin.token_file: t -> ''");
}

TEST(ConfigChanges, SayNothingOfOrderCommentsAndQuotes) {
  EXPECT_EQ(
      changes("server: {max_sessions: 7, listen: '::1'} # one", "server:\n  listen: \"::1\"\n  max_sessions: 7"),
      "");
  EXPECT_EQ(changes("tenants: [{name: a}, {name: b, weight: 2}]", "tenants: [{name: b, weight: 2}, {name: a}]"),
            "");
}

TEST(ConfigChanges, NameTheTenant) {
  EXPECT_EQ(changes("tenants: [{name: a, weight: 1}, {name: b}]", "tenants: [{name: c}, {name: a, weight: 3}]"),
            "tenants.a.weight: 1 -> 3, tenants.b: removed, tenants.c: added");
  EXPECT_EQ(changes("tenants: [{name: a, weight: 2, priority: 1}]", "tenants: [{name: c, weight: 2}]"),
            "tenants.a: removed, tenants.c: added, tenants.c.weight: (default) -> 2");
  EXPECT_EQ(changes("{}", "fleet: {name: edge.example}"), "fleet.name: (default) -> edge.example");
}

TEST(ConfigChanges, AnOverrideReplacesAListAndAddsToAMap) {
  EXPECT_EQ(changes("{server: {max_sessions: 7}, tenants: [{name: a}]}",
                    "{server: {max_sessions: 7}, tenants: [{name: a}]}",
                    {"tenants=[{name: b}]", "server.drain_timeout_ms=5"}),
            "server.drain_timeout_ms: (default) -> 5, tenants.a: removed, tenants.b: added");
}

TEST(ConfigChanges, CountTokensAndShowNoneOfTheirHashes) {
  const auto tenant = [](char a, char b) {
    return "tenants: [{name: a, token_sha256: [" + std::string(64, a) + ", " + std::string(64, b) + "]}]";
  };
  EXPECT_EQ(changes(tenant('1', '2'), tenant('2', '3')), "tenants.a.token_sha256: 1 added, 1 removed");
  EXPECT_EQ(changes("tenants: [{name: a}]", tenant('2', '3')), "tenants.a.token_sha256: 2 added, 0 removed");
  EXPECT_EQ(changes(tenant('2', '3'), "tenants: [{name: a}]"), "tenants.a.token_sha256: 0 added, 2 removed");
  EXPECT_EQ(changes(tenant('2', '3'), tenant('3', '2')), "tenants.a.token_sha256: 0 added, 0 removed")
      << "their order";
}

TEST(Config, StrangersAreServedOnLoopbackOrWhereItIsSaidSo) {
  const auto accepted = [](const std::string& server) { return parse_config(server, "edge.yaml").has_value(); };
  EXPECT_TRUE(accepted("server: {mode: demo}\n"));
  EXPECT_TRUE(accepted("server: {mode: demo, listen: 127.8.9.1}\n"));
  EXPECT_TRUE(accepted("server: {mode: demo, listen: '::1'}\n"));
  EXPECT_TRUE(accepted("server: {listen: 0.0.0.0}\n")) << "tenants need tokens there";
  EXPECT_TRUE(accepted("server: {mode: demo, listen: 0.0.0.0, insecure_listen: true}\n"));
  EXPECT_TRUE(accepted("server: {listen: 0.0.0.0, insecure_listen: true}\ntenants: [{name: lab, open: true}]\n"));
  EXPECT_FALSE(accepted("server: {mode: demo, listen: 10.0.0.1}\n"));
  EXPECT_FALSE(accepted("server: {mode: demo, listen: 'fe80::1'}\n"));
}

}  // namespace
}  // namespace gnomon::daemon
