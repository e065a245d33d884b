// Cases of gnomon-bench transport: sessions over bad links in virtual time (tests/unit/link/scenarios.h). The figures
// depend only on the seed, not on the machine.
#include "tests/bench/transport.h"
#include "tests/unit/link/scenarios.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;
using Rows = std::vector<ordered_json>;
using namespace std::chrono_literals;

constexpr uint64_t kSeed = 1;

ordered_json loss_row(const char* name, const tests::LossFigures& figures) {
  return {{"case", name},
          {"seed", kSeed},
          {"fresh_tiles_share", figures.fresh_share},
          {"longest_gap_ms", to_milliseconds(figures.longest_gap)},
          {"retransmitted", figures.retransmitted},
          {"recovered_slices", figures.recovered}};
}

Result<Rows> random_loss(const TransportOptions&) {
  Rows rows;
  for (const Nanoseconds delay : {2ms, 25ms, 60ms}) {
    rows.push_back(loss_row("loss_5_percent", tests::random_loss(kSeed, delay)));
    rows.back()["delay_ms"] = to_milliseconds(delay);
  }
  rows.push_back(loss_row("loss_in_bursts", tests::bursty_loss(kSeed)));
  return rows;
}

Result<Rows> heavy_loss(const TransportOptions&) {
  const tests::LossFigures figures = tests::heavy_loss(kSeed);
  Rows rows{loss_row("loss_30_percent_5_s", figures)};
  rows.back()["recovery_ms"] = to_milliseconds(figures.recovery);
  return rows;
}

Result<Rows> bottleneck(const TransportOptions&) {
  Rows rows;
  for (const bool start : {true, false}) {
    const tests::QueueFigures figures = tests::bottleneck(kSeed, start);
    rows.push_back({{"case", start ? "bottleneck_10_mbit_first_second" : "bottleneck_10_mbit"},
                    {"seed", kSeed},
                    {"queue_delay_ms", to_milliseconds(figures.wait_p95)},
                    {"longest_queue_delay_ms", to_milliseconds(figures.wait_max)},
                    {"mbit_per_s", 10 * figures.used_share}});
  }
  return rows;
}

Result<Rows> sharing(const TransportOptions&) {
  Rows rows;
  for (const auto& [sessions, tcp] : {std::pair(2u, false), std::pair(1u, true), std::pair(2u, true)}) {
    const tests::Shares shares = tests::sharing(kSeed, sessions, tcp);
    rows.push_back({{"case", tcp ? "sharing_with_tcp" : "sharing"},
                    {"seed", kSeed},
                    {"sessions", sessions},
                    {"least_session_share", *std::min_element(shares.sessions.begin(), shares.sessions.end())},
                    {"tcp_share", shares.tcp},
                    {"queue_delay_ms", to_milliseconds(shares.wait_p95)}});
  }
  return rows;
}

Result<Rows> narrowing_path(const TransportOptions&) {
  const tests::MtuFigures figures = tests::narrowing_path(kSeed);
  return Rows{{{"case", "narrowing_path"},
               {"seed", kSeed},
               {"datagram_bytes", figures.found},
               {"datagram_bytes_after", figures.after},
               {"longest_gap_ms", to_milliseconds(figures.longest_gap)},
               {"fresh_tiles_share", figures.fresh_share}}};
}

}  // namespace

std::vector<TransportCase> link_cases() {
  return {{"loss", random_loss},
          {"heavy_loss", heavy_loss},
          {"bottleneck", bottleneck},
          {"sharing", sharing},
          {"narrowing_path", narrowing_path}};
}

}  // namespace gnomon::bench
