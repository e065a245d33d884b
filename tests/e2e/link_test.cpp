// Sessions over bad links: the real daemon, the real client library, netsim between them.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/e2e/flier.h"

namespace gnomon::tests {
namespace {

// The daemon's ports at another address of this machine, through a simulated link.
class Relay {
 public:
  Relay(const Daemon& daemon, std::vector<std::string> link) : address_{"127.0.0.2", daemon.address().port} {
    link.insert(link.end(), {"--listen", address_.host, "--to", daemon.address().host, "--tcp",
                             std::to_string(daemon.address().port), "--udp", std::to_string(daemon.data_port())});
    process_.emplace("netsim", link, folder_.path());
    eventually([&] { return process_->output().find("relaying") != std::string::npos || !process_->running(); });
  }

  const client::Address& address() const { return address_; }
  Process& process() { return *process_; }

 private:
  TemporaryFolder folder_;
  client::Address address_;
  std::optional<Process> process_;
};

// Lossy, not slow: a slow machine has its own queues.
TEST(Link, LostSlicesComeAgain) {
  Daemon daemon;
  Relay relay(daemon, {"--delay", "5ms", "--loss", "10%", "--seed", "3"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 60)) << relay.process().output();
  ASSERT_TRUE(eventually([&] {
    loop.poll();
    return daemon.metric("gnomon_datagrams_lost_total") > 0;
  }));
  const client::StreamCounters& counters = fliers[0]->stream().counters();
  EXPECT_GE(counters.complete, 60u);
  EXPECT_GT(daemon.metric("gnomon_datagrams_retransmitted_total") + daemon.metric("gnomon_slices_recovered_total"),
            0);
  EXPECT_EQ(counters.wrong_frames, 0u);
}

TEST(Link, GoesByIPv6Too) {
  const int probe = socket(AF_INET6, SOCK_DGRAM, 0);
  sockaddr_in6 local{};
  local.sin6_family = AF_INET6;
  local.sin6_addr = in6addr_loopback;
  const bool has_ipv6 = probe >= 0 && bind(probe, reinterpret_cast<sockaddr*>(&local), sizeof local) == 0;
  if (probe >= 0) close(probe);
  if (!has_ipv6) GTEST_SKIP() << "this machine has no IPv6: nothing listens on ::1";
  std::string config = kConfig;
  config.replace(config.find("127.0.0.1"), 9, "'::1'");
  Daemon daemon(config);
  ASSERT_EQ(daemon.address().host, "::1");
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(std::make_unique<Flier>(loop, daemon, "studio", living_room_path()));
  ASSERT_TRUE(all_progress(loop, fliers, 10));
  EXPECT_EQ(fliers[0]->stream().counters().wrong_frames, 0u);
}

TEST(Link, ANarrowOneIsFollowedNotFilled) {
  Daemon daemon;
  Relay relay(daemon, {"--delay", "5ms", "--rate", "1mbit", "--queue", "500ms"});
  client::Loop loop;
  Fliers fliers;
  fliers.push_back(
      std::make_unique<Flier>(loop, daemon, "studio", living_room_path(), kSmall, "living_room", relay.address()));
  ASSERT_TRUE(all_progress(loop, fliers, 40)) << relay.process().output();
  relay.process().signal(SIGTERM);
  relay.process().wait();
  EXPECT_NE(relay.process().output().find(" 0 found the queue full"), std::string::npos)
      << relay.process().output();
}

}  // namespace
}  // namespace gnomon::tests
