// netsim: simulates a bad link between a client and a server, on loopback.
//
//   netsim --tcp 7600 --udp 7600 --delay 50ms --jitter 5ms --loss 2% --rate 20mbit
//   gnomon-client --server 127.0.0.2:7600 ...
#include <CLI/CLI.hpp>
#include <asio/signal_set.hpp>
#include <cstdio>

#include "tests/tools/netsim/relay.h"

namespace {

using namespace gnomon;
using netsim::Profile;
using netsim::Schedule;

struct Options {
  netsim::RelayOptions relay;
  std::vector<std::pair<std::string, std::string>> both;  // key, value
  std::string up, down;
  std::vector<std::string> phases;  // TIME:KEY=VALUE,...
};

// Each phase starts from the profile of the one before it.
Result<Schedule> schedule_of(const Options& options, const std::string& direction) {
  Profile profile;
  for (const auto& [key, value] : options.both) {
    if (value.empty()) continue;
    if (auto done = netsim::apply(std::string(key).append("=").append(value), profile); !done) return done.error();
  }
  if (auto done = netsim::apply(direction, profile); !done) return done.error();
  Schedule schedule{{Nanoseconds{}, profile}};
  for (const std::string& phase : options.phases) {
    const size_t colon = std::min(phase.find(':'), phase.size());
    const auto from = netsim::parse_time(phase.substr(0, colon));
    if (!from) return from.error();
    if (*from < schedule.back().from) return Error{"--at " + phase + " comes before the one named before it"};
    if (auto done = netsim::apply(phase.substr(std::min(colon + 1, phase.size())), profile); !done) {
      return done.error();
    }
    schedule.push_back({*from, profile});
  }
  return schedule;
}

int fail(const Error& error) {
  std::fprintf(stderr, "netsim: %s\n", error.message.c_str());
  return 1;
}

int relay(Options& options) {
  auto up = schedule_of(options, options.up), down = schedule_of(options, options.down);
  if (!up) return fail(up.error());
  if (!down) return fail(down.error());
  options.relay.up = *up;
  options.relay.down = *down;
  asio::io_context io{1};
  const auto made = netsim::Relay::open(io, options.relay);
  if (!made) return fail(made.error());
  asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const asio::error_code&, int) { io.stop(); });
  std::printf("netsim: relaying %s to %s\n", options.relay.listen.c_str(), options.relay.to.c_str());
  std::fflush(stdout);
  io.run();
  const auto& count = (*made)->counters();
  const auto number = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  std::printf(
      "netsim: %llu datagrams, %llu lost, %llu found the queue full, %llu blocked, the longest of %llu bytes\n",
      number(count.datagrams), number(count.lost), number(count.queue_full), number(count.blocked),
      number(count.longest));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Relays TCP and UDP on loopback through a simulated link. Clients connect to the --listen address and the "
      "server's own port numbers.");
  Options options;
  app.add_option("--listen", options.relay.listen, "numeric address that clients connect to")
      ->capture_default_str();
  app.add_option("--to", options.relay.to, "numeric address of the server")->capture_default_str();
  app.add_option("--tcp", options.relay.tcp_ports, "ports to relay: the server's control port");
  app.add_option("--udp", options.relay.udp_ports, "ports to relay: the server's data ports");
  app.add_option("--seed", options.relay.seed, "the same seed and traffic: the same luck")->capture_default_str();
  const std::pair<const char*, const char*> properties[] = {
      {"delay", "each way, as 50ms"},
      {"jitter", "the delay swings by this, as 5ms"},
      {"loss", "of datagrams, as 2%"},
      {"burst", "chance to enter a burst of losses and to leave it, as 1%:30%"},
      {"reorder", "datagrams held back, as 1%"},
      {"reorder_by", "for how long, as 10ms"},
      {"duplicate", "datagrams that come twice, as 1%"},
      {"rate", "of the bottleneck, each way, as 20mbit"},
      {"queue", "before the bottleneck, as 100ms or 64kb"},
      {"mtu", "the longest payload of a datagram that passes, in bytes, as 1280; 0: all pass"},
      {"udp", "on or off: whether datagrams pass at all"}};
  for (const auto& [key, about] : properties) options.both.emplace_back(key, "");
  for (size_t i = 0; i < options.both.size(); ++i) {
    auto& [key, value] = options.both[i];
    const std::string name = key == "udp" ? "udp-traffic" : key;  // --udp names the ports
    app.add_option("--" + name, value, properties[i].second);
  }
  app.add_option("--up", options.up, "for clients' datagrams alone, as loss=5%,delay=10ms");
  app.add_option("--down", options.down, "for the server's datagrams alone");
  app.add_option("--at", options.phases, "a change after a time, as 5s:loss=30%; may be given again");
  CLI11_PARSE(app, argc, argv);
  return relay(options);
}
