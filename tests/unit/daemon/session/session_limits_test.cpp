// Places for sessions: by address, by tenant, and what is reserved for tenants that have few.
#include "daemon/session/session_limits.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

ClientNetwork at(const std::string& address) { return network_of(asio::ip::make_address(address)); }

class SessionLimitsTest : public testing::Test {
 protected:
  // Takes places for the tenant, each from another address, until it is refused; how many it got.
  uint32_t take_all(SessionLimits& limits, uint32_t tenant) {
    for (uint32_t taken = 0;; ++taken) {
      auto permit = limits.take(TenantId{tenant}, network_of(asio::ip::address_v4(++address_)));
      if (!std::holds_alternative<SessionPermit>(permit)) return taken;
      permits_.push_back(std::get<SessionPermit>(std::move(permit)));
    }
  }

  static Config with(std::vector<TenantConfig> tenants) {
    Config config;
    config.server.max_sessions = 80;
    config.tenants = std::move(tenants);
    return config;
  }

  std::vector<SessionPermit> permits_;  // destroyed before the limits, which each test makes
  uint32_t address_ = 0;
};

TEST_F(SessionLimitsTest, AnAddressIsAHome) {
  Config config;
  config.server.max_sessions_per_address = 1;
  SessionLimits limits(config);
  {
    const auto first = limits.take(TenantId{0}, at("2001:db8:1:2::1"));
    EXPECT_TRUE(std::holds_alternative<SessionPermit>(first));
    EXPECT_TRUE(std::holds_alternative<protocol::Refused>(limits.take(TenantId{0}, at("2001:db8:1:2::2"))));
    EXPECT_TRUE(std::holds_alternative<SessionPermit>(limits.take(TenantId{0}, at("2001:db8:1:3::1"))));
    EXPECT_TRUE(std::holds_alternative<SessionPermit>(limits.take(TenantId{0}, at("192.0.2.1"))));
  }
  EXPECT_TRUE(std::holds_alternative<SessionPermit>(limits.take(TenantId{0}, at("2001:db8:1:2::2"))));
}

TEST_F(SessionLimitsTest, ATenantAloneMayHaveAllPlaces) {
  SessionLimits limits(with({{.name = "a"}}));
  EXPECT_EQ(take_all(limits, 0), 80u);
  permits_.clear();
}

TEST_F(SessionLimitsTest, NoTenantsTogetherTakeWhatIsReservedForAnother) {
  SessionLimits limits(with({{.name = "a"}, {.name = "b"}, {.name = "c"}, {.name = "d"}}));
  EXPECT_EQ(take_all(limits, 0), 80u - 3 * 10) << "half of all is reserved, 10 for each";
  EXPECT_EQ(take_all(limits, 1), 10u);
  EXPECT_EQ(take_all(limits, 2), 10u);
  EXPECT_EQ(take_all(limits, 3), 10u) << "whatever the others have";
  EXPECT_EQ(limits.taken(), 80u);
  permits_.clear();
}

TEST_F(SessionLimitsTest, AnExplicitZeroIsNoLimit) {
  SessionLimits limits(with({{.name = "a", .max_sessions = 0}, {.name = "b"}}));
  EXPECT_EQ(take_all(limits, 0), 80u);
  permits_.clear();
}

TEST_F(SessionLimitsTest, ANumberIsALimitAndReservesNoMore) {
  SessionLimits limits(with({{.name = "a", .max_sessions = 4}, {.name = "b"}}));
  EXPECT_EQ(take_all(limits, 1), 76u);
  EXPECT_EQ(take_all(limits, 0), 4u);
  permits_.clear();
}

TEST_F(SessionLimitsTest, NothingIsReservedForWhoIsNoLongerServed) {
  const Config before = with({{.name = "a"}, {.name = "b"}}), after = with({{.name = "a"}});
  SessionLimits limits(before);
  limits.set_limits(after, TenantDirectory().with(before.tenants).with(after.tenants));
  EXPECT_EQ(take_all(limits, 0), 80u);
  permits_.clear();
}

}  // namespace
}  // namespace gnomon::daemon
