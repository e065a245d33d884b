// What strangers send to WebTransport's port: packets before a handshake, and, as the seal of QUIC stops a fuzzer, the
// bytes of HTTP/3 that come after one. Memory stays within its bounds, and nothing that is no session asks for one.
#include <algorithm>

#include "daemon/quic/endpoint.h"
#include "daemon/quic/http3.h"
#include "daemon/quic/qpack.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

using daemon::quic::Http3;

constexpr size_t kMostPackets = 64;

// Steps of a stream, the bytes that it gets, and whether it ends.
void read_streams(std::span<const uint8_t> input) {
  Http3 http;
  size_t asked = 0;
  while (!input.empty()) {
    const int64_t stream = take_number(input, 63);
    const uint32_t how = take_number(input, 511);
    const auto bytes = take(input, how / 2);
    if (http.receive(stream, bytes, how % 2 == 1)) break;
    if (how == 510) http.reset(stream);
    if (const auto session = http.take_asked()) {
      ++asked;
      require(session->path.size() <= daemon::quic::kLongestField, "fields have a bound");
      require(!http.response(200).empty(), "a session can be answered");
      require(http.payload(http.datagram_prefix()).has_value(), "a session knows its datagrams");
    }
  }
  require(asked <= 1, "a connection has one session");
}

// Packets, each with its length, to an endpoint of its own.
void read_packets(std::span<const uint8_t> input) {
  static const daemon::Identity identity =
      *daemon::make_certificate({.name = "fuzz", .hosts = {"here"}, .lasts = std::chrono::hours(24)});
  daemon::quic::Options options{.identity = identity, .local = {}, .limits = {}};
  options.local.size = 16;
  options.local.bytes[0] = 2;  // AF_INET
  options.limits.retry_above = 4;
  options.limits.half_open = 8;
  const auto endpoint = std::move(*daemon::quic::make_endpoint(options));
  TimePoint now{std::chrono::hours(1)};
  daemon::quic::Address from = options.local;
  for (size_t i = 0; i < kMostPackets && !input.empty(); ++i) {
    const uint32_t size = take_number(input, 1500);
    from.bytes[3] = static_cast<uint8_t>(take_number(input, 3));
    std::vector<uint8_t> packet(size);  // short ones are filled, as first packets have 1,200 bytes
    const auto bytes = take(input, size);
    std::ranges::copy(bytes, packet.begin());
    endpoint->receive(packet, from, now);
    size_t answered = 0;
    for (const auto& answer : endpoint->take_packets(now)) answered += answer.bytes.size();
    require(answered <= 3 * std::max<size_t>(packet.size(), 1200), "no amplification");
    for (const auto& event : endpoint->take_events()) {
      require(!std::holds_alternative<daemon::quic::Datagram>(event.what), "no datagram without a session");
    }
    require(endpoint->half_open() <= options.limits.half_open, "half-open connections have a bound");
    now += std::chrono::milliseconds(20);
    if (endpoint->wake_at() <= now) endpoint->expire(now);
  }
}

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::span<const uint8_t> input(data, size);
  if (gnomon::fuzz::take_number(input, 1) == 0) {
    gnomon::fuzz::read_streams(input);
  } else {
    gnomon::fuzz::read_packets(input);
  }
  return 0;
}
