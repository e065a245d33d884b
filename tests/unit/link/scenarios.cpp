#include "tests/unit/link/scenarios.h"

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "tests/unit/link/simulated_session.h"
#include "tests/unit/link/tcp_flow.h"

namespace gnomon::tests {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{1s};
constexpr TileGrid kGrid{512, 256, 2};  // a frame of it is about 34 kB

struct World {
  EventQueue events;
  netsim::Link up, down;
  std::vector<std::unique_ptr<SimulatedSession>> sessions;

  World(netsim::Schedule up_schedule, netsim::Schedule down_schedule, uint64_t seed)
      : up(std::move(up_schedule), seed, kStart), down(std::move(down_schedule), ~seed, kStart) {}

  SimulatedSession& add(TimePoint start, Nanoseconds path_delay, bool longer_slices = false) {
    SessionPlan plan;
    plan.grid = kGrid;
    plan.busy = 0.9;
    plan.start = start;
    plan.path_delay = path_delay;
    plan.longer_slices = longer_slices;
    return *sessions.emplace_back(std::make_unique<SimulatedSession>(events, up, down, plan));
  }
};

netsim::Profile profile(std::string_view text) {
  netsim::Profile made;
  if (!netsim::apply(text, made)) std::abort();
  return made;
}

LossFigures figures(const SimulatedSession& session, TimePoint from, TimePoint to) {
  return {session.fresh_share(from, to),
          session.longest_gap(from, to),
          {},
          session.link().counters().retransmitted,
          session.recovered()};
}

LossFigures lossy(const netsim::Profile& down, const netsim::Profile& up, uint64_t seed) {
  World world({{0s, up}}, {{0s, down}}, seed);
  const SimulatedSession& session = world.add(kStart, down.delay + down.jitter);
  world.events.run_until(kStart + 22s);
  return figures(session, kStart + 2s, kStart + 22s);
}

}  // namespace

LossFigures random_loss(uint64_t seed, Nanoseconds delay) {
  netsim::Profile path = profile("loss=5%,jitter=1ms");
  path.delay = delay;
  return lossy(path, path, seed);
}

LossFigures bursty_loss(uint64_t seed) {
  return lossy(profile("delay=25ms,jitter=1ms,burst=0.5%:20%"), profile("delay=25ms,jitter=1ms"), seed);
}

LossFigures heavy_loss(uint64_t seed) {
  const auto good = profile("delay=25ms,jitter=1ms"), bad = profile("delay=25ms,jitter=1ms,loss=30%");
  const netsim::Schedule schedule{{0s, good}, {5s, bad}, {10s, good}};
  World world(schedule, schedule, seed);
  const SimulatedSession& session = world.add(kStart, good.delay + good.jitter);
  world.events.run_until(kStart + 15s);
  LossFigures made = figures(session, kStart + 5s, kStart + 10s);
  TimePoint last_bad = kStart + 10s;
  for (const Look& look : session.looks()) {
    if (look.fresh < 1) last_bad = std::max(last_bad, look.at);
  }
  made.recovery = last_bad - (kStart + 10s);
  return made;
}

QueueFigures bottleneck(uint64_t seed, bool start, Nanoseconds delay) {
  netsim::Profile up = profile("delay=0ms"), down = profile("rate=10mbit,queue=500ms");
  up.delay = down.delay = delay;
  World world({{0s, up}}, {{0s, down}}, seed);
  SimulatedSession& session = world.add(kStart, delay);
  world.events.run_until(kStart + 1s);
  QueueFigures first{session.wait_percentile(0.95), session.wait_percentile(1), 0};
  session.forget_waits();
  const uint64_t before = session.delivered_bytes();
  world.events.run_until(kStart + (start ? 2s : 31s));
  const double bits = static_cast<double>(session.delivered_bytes() - before) * 8;
  const double used = bits / ((start ? 1 : 30) * 10e6);
  if (start) return {first.wait_p95, first.wait_max, used};
  return {session.wait_percentile(0.95), session.wait_percentile(1), used};
}

Shares sharing(uint64_t seed, uint32_t sessions, bool tcp) {
  World world({{0s, profile("delay=20ms")}}, {{0s, profile("delay=20ms,rate=20mbit,queue=100ms")}}, seed);
  for (uint32_t i = 0; i < sessions; ++i) world.add(kStart + i * 3s, 20ms);
  std::unique_ptr<TcpFlow> flow;
  if (tcp) flow = std::make_unique<TcpFlow>(world.events, world.down, world.up, kStart + sessions * 3s);
  world.events.run_until(kStart + 20s);
  std::vector<uint64_t> before;
  for (const auto& session : world.sessions) {
    before.push_back(session->delivered_bytes());
    session->forget_waits();
  }
  const uint64_t tcp_before = flow ? flow->delivered_bytes() : 0;
  world.events.run_until(kStart + 60s);

  Shares shares;
  double sum = flow ? static_cast<double>(flow->delivered_bytes() - tcp_before) : 0;
  shares.tcp = sum;
  for (size_t i = 0; i < before.size(); ++i) {
    shares.sessions.push_back(static_cast<double>(world.sessions[i]->delivered_bytes() - before[i]));
    sum += shares.sessions.back();
    shares.wait_p95 = std::max(shares.wait_p95, world.sessions[i]->wait_percentile(0.95));
  }
  shares.tcp /= sum;
  for (double& share : shares.sessions) share /= sum;
  return shares;
}

MtuFigures narrowing_path(uint64_t seed) {
  const auto wide = profile("delay=25ms,mtu=1472"), narrow = profile("delay=25ms,mtu=1300");
  World world({{0s, profile("delay=25ms")}}, {{0s, wide}, {5s, narrow}}, seed);
  const SimulatedSession& session = world.add(kStart, 25ms, true);
  world.events.run_until(kStart + 5s);
  MtuFigures figures;
  figures.found = session.link().datagram_bytes();
  world.events.run_until(kStart + 15s);
  figures.after = session.link().datagram_bytes();
  TimePoint last = kStart + 5s;
  for (const Look& look : session.looks()) {
    if (look.at < last || look.fresh < 1) continue;
    figures.longest_gap = std::max(figures.longest_gap, look.at - last);
    last = look.at;
  }
  figures.longest_gap = std::max(figures.longest_gap, world.events.now() - last);
  figures.fresh_share = session.fresh_share(kStart + 10s, kStart + 15s);
  return figures;
}

}  // namespace gnomon::tests
