// netsim-tun: the simulated link for whole IP packets, so that TCP's and QUIC's own answers to loss are met. Two TUN
// devices, one here and one in another network namespace, are joined by one netsim::Link each way. Needs root.
//
//   ip netns add far && netsim-tun --netns far --delay 10ms --loss 1%
//   10.99.0.1 is here, 10.99.0.2 is there
#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <vector>

#include "tests/tools/netsim/link.h"

namespace {

using namespace gnomon;
using netsim::Link;

constexpr const char* kMtu = "1400";
constexpr size_t kMostBytes = 2000;

int fail(const std::string& what) {
  std::fprintf(stderr, "netsim-tun: %s: %s\n", what.c_str(), std::strerror(errno));
  return 1;
}

int open_tun(const char* name) {
  const int tun = open("/dev/net/tun", O_RDWR | O_NONBLOCK);
  ifreq request{};
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strncpy(request.ifr_name, name, IFNAMSIZ - 1);
  return tun >= 0 && ioctl(tun, TUNSETIFF, &request) == 0 ? tun : -1;
}

bool configure(const std::string& device, const std::string& address) {
  const std::string command = "ip addr add " + address + "/30 dev " + device + " && ip link set " + device +
                              " mtu " + kMtu + " up && ip link set lo up";
  return std::system(command.c_str()) == 0;
}

// One direction: what a device here sends reaches the device there later, or never.
struct Direction {
  int from, to;
  Link link;
  std::multimap<TimePoint, std::vector<uint8_t>> flying = {};

  void take() {
    std::array<uint8_t, kMostBytes> packet;
    for (ssize_t size; (size = read(from, packet.data(), packet.size())) > 0;) {
      const auto bytes = static_cast<size_t>(size);
      for (const TimePoint at : link.send(bytes, Clock::now()).arrivals()) {
        flying.emplace(at, std::vector<uint8_t>(packet.data(), packet.data() + bytes));
      }
    }
  }

  void give(TimePoint now) {
    while (!flying.empty() && flying.begin()->first <= now) {
      const auto& packet = flying.begin()->second;
      if (write(to, packet.data(), packet.size()) < 0) {  // the device takes no more: lost
      }
      flying.erase(flying.begin());
    }
  }
};

[[noreturn]] void serve(std::array<Direction, 2> ways) {
  for (;;) {
    TimePoint next = Clock::now() + std::chrono::seconds(1);
    for (const Direction& way : ways) {
      if (!way.flying.empty()) next = std::min(next, way.flying.begin()->first);
    }
    const auto wait = std::max(Nanoseconds{}, Nanoseconds(next - Clock::now()));
    const timespec timeout{wait.count() / 1'000'000'000, wait.count() % 1'000'000'000};
    std::array<pollfd, 2> waiting{pollfd{ways[0].from, POLLIN, 0}, pollfd{ways[1].from, POLLIN, 0}};
    ppoll(waiting.data(), waiting.size(), &timeout, nullptr);
    for (Direction& way : ways) way.take();
    for (Direction& way : ways) way.give(Clock::now());
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Joins this network namespace to another by a simulated link for IP packets.");
  std::string there, delay = "10ms", loss = "0%", rate;
  app.add_option("--netns", there, "the other namespace, as `ip netns` names it")->required();
  app.add_option("--delay", delay, "each way")->capture_default_str();
  app.add_option("--loss", loss, "of packets, each way")->capture_default_str();
  app.add_option("--rate", rate, "of the bottleneck, each way, as 10mbit; unlimited if left out");
  CLI11_PARSE(app, argc, argv);
  netsim::Profile profile;
  const std::string text = "delay=" + delay + ",loss=" + loss + (rate.empty() ? "" : ",rate=" + rate);
  if (auto done = netsim::apply(text, profile); !done) {
    std::fprintf(stderr, "netsim-tun: %s\n", done.error().message.c_str());
    return 1;
  }
  const int home = open("/proc/self/ns/net", O_RDONLY);
  const int here = open_tun("netsim0");
  if (here < 0 || !configure("netsim0", "10.99.0.1")) return fail("the device here");
  const int away = open(("/var/run/netns/" + there).c_str(), O_RDONLY);
  if (away < 0 || setns(away, CLONE_NEWNET) != 0) return fail("the namespace " + there);
  const int far = open_tun("netsim1");
  if (far < 0 || !configure("netsim1", "10.99.0.2") || setns(home, CLONE_NEWNET) != 0)
    return fail("the device there");
  std::printf("netsim-tun: 10.99.0.1 to 10.99.0.2, %s\n", text.c_str());
  std::fflush(stdout);
  const TimePoint now = Clock::now();
  serve({Direction{here, far, Link({{Nanoseconds{}, profile}}, 7, now)},
         Direction{far, here, Link({{Nanoseconds{}, profile}}, 8, now)}});
}
