// Cases of gnomon-bench transport: the cost of the seal alone: sealing, opening, and rejecting forged datagrams.
#include "tests/bench/transport_traffic.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;
using protocol::CipherId;
using protocol::Seal;
using protocol::Side;
using Bytes = std::vector<uint8_t>;

// The bodies of a frame's slices.
Result<std::vector<Bytes>> frame_bodies() {
  const auto frame = busy_frame(protocol::kMaxSliceBodyBytes);
  if (!frame) return frame.error();
  std::vector<Bytes> bodies;
  for (size_t i = 0; i < frame->slices.size(); ++i) {
    protocol::append_frame_slice(bodies.emplace_back(), frame->slices[i], frame->payload(i));
  }
  return bodies;
}

struct Seals {
  Seal server, client;
};

Seals seals(CipherId cipher) {
  return {.server{kBenchSession, cipher, kBenchSecrets, Side::server},
          .client{kBenchSession, cipher, kBenchSecrets, Side::client}};
}

size_t bytes_of(const std::vector<Bytes>& datagrams) {
  size_t sum = 0;
  for (const Bytes& datagram : datagrams) sum += datagram.size();
  return sum;
}

// Calls `send_frame` repeatedly for `time`. Returns this thread's processor seconds for each call.
template <class SendFrame>
double seconds_per_frame(std::chrono::duration<double> time, SendFrame send_frame) {
  const auto end = std::chrono::steady_clock::now() + time;
  const double before = cpu_seconds();
  size_t frames = 0;
  do {
    send_frame();
    ++frames;
  } while (std::chrono::steady_clock::now() < end);
  return (cpu_seconds() - before) / static_cast<double>(frames);
}

using Rows = std::vector<ordered_json>;

// Measures each cipher with the bodies of one frame.
Result<Rows> of_each_cipher(Result<Rows> (*measure)(const TransportOptions&, CipherId, const std::vector<Bytes>&),
                            const TransportOptions& options) {
  const auto bodies = frame_bodies();
  if (!bodies) return bodies.error();
  Rows rows;
  for (const CipherId cipher : kCiphers) {
    const auto measured = measure(options, cipher, *bodies);
    if (!measured) return measured.error();
    rows.insert(rows.end(), measured->begin(), measured->end());
  }
  return rows;
}

Result<Rows> seal_alone(const TransportOptions& options, CipherId cipher, const std::vector<Bytes>& bodies) {
  Seals both = seals(cipher);
  Seal &server = both.server, &client = both.client;
  std::vector<Bytes> datagrams(bodies.size());
  double open_s = 0;
  size_t opened = 0, frames = 0;
  const double both_s = seconds_per_frame(options.seconds, [&] {
    for (size_t i = 0; i < bodies.size(); ++i) {
      server.seal(protocol::DatagramKind::frame_slice, bodies[i], datagrams[i]);
    }
    const double before = cpu_seconds();
    for (const Bytes& datagram : datagrams) opened += client.open(datagram).has_value();
    open_s += cpu_seconds() - before;
    ++frames;
  });
  if (opened != frames * bodies.size()) return Error{"datagrams were not opened"};
  const double open_of_frame_s = open_s / static_cast<double>(frames);
  const size_t bytes = bytes_of(datagrams);
  return Rows{traffic_row("seal", name_of(cipher), bodies.size(), bytes, both_s - open_of_frame_s),
              traffic_row("open", name_of(cipher), bodies.size(), bytes, open_of_frame_s)};
}

// A datagram damaged at every byte in turn: how fast the forgeries are rejected, and that none is accepted.
Result<Rows> forgeries(const TransportOptions& options, CipherId cipher, const std::vector<Bytes>& bodies) {
  Seals both = seals(cipher);
  Seal &server = both.server, &client = both.client;
  Bytes datagram;
  server.seal(protocol::DatagramKind::frame_slice, bodies.front(), datagram);
  size_t accepted = 0;
  // From byte 12 on, as the bytes before are checked before anything is decrypted.
  const double cpu_s = seconds_per_frame(options.seconds, [&] {
    for (size_t at = 12; at < datagram.size(); ++at) {
      datagram[at] ^= 0x01;
      accepted += client.open(datagram).has_value();
      datagram[at] ^= 0x01;
    }
  });
  const size_t count = datagram.size() - 12;
  ordered_json row = traffic_row("forgeries", name_of(cipher), count, count * datagram.size(), cpu_s);
  row["accepted_forgeries"] = accepted;
  return Rows{std::move(row)};
}

}  // namespace

std::vector<TransportCase> seal_cases() {
  return {{"seal", [](const TransportOptions& options) { return of_each_cipher(seal_alone, options); }},
          {"forgeries", [](const TransportOptions& options) { return of_each_cipher(forgeries, options); }}};
}

}  // namespace gnomon::bench
