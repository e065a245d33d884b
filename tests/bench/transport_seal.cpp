// What the seal costs: sealing and opening alone, forged datagrams, and frames of 1080p sealed and sent in paced batches
// beside the same bytes handed to plain sendmmsg.
#include <sys/socket.h>
#include <time.h>

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <atomic>
#include <thread>

#include "daemon/data_socket.h"
#include "protocol/codec.h"
#include "protocol/seal.h"
#include "tests/bench/report.h"
#include "tests/bench/transport.h"
#include "tests/protocol/masks.h"

namespace gnomon::bench {
namespace {

using asio::ip::udp;
using nlohmann::ordered_json;
using protocol::CipherId;
using protocol::Seal;
using protocol::Side;
using Bytes = std::vector<uint8_t>;

constexpr SessionId kSession{0x1234567890abcdef};
constexpr protocol::SealSecrets kSecrets{{1, 2, 3}, {4, 5, 6}};

const char* name_of(CipherId cipher) {
  return cipher == CipherId::aes_128_gcm ? "aes_128_gcm" : "chacha20_poly1305";
}

// Of the calling thread.
double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The slices of a frame with much in it, as their bodies.
std::vector<Bytes> frame_bodies() {
  const tests::Mask mask = tests::foliage({1920, 1080, 3}, 1);
  protocol::FrameEncoder encoder;
  protocol::EncodedFrame frame;
  std::vector<Bytes> bodies;
  if (!encoder.encode(mask.view(), protocol::CodecId::tiles_lz4, protocol::kMaxSlicePayloadBytes, frame)) return {};
  for (size_t i = 0; i < frame.slices.size(); ++i) {
    protocol::append_frame_slice(bodies.emplace_back(), frame.slices[i], frame.payload(i));
  }
  return bodies;
}

size_t bytes_of(const std::vector<Bytes>& datagrams) {
  size_t sum = 0;
  for (const Bytes& datagram : datagrams) sum += datagram.size();
  return sum;
}

// A socket on loopback that another thread empties.
class Sink {
 public:
  Sink() : socket_(io_, udp::endpoint(asio::ip::address_v4::loopback(), 0)) {
    socket_.set_option(asio::socket_base::receive_buffer_size(4 << 20));
    thread_ = std::thread([this] { drain(); });
  }
  ~Sink() {
    done_ = true;
    udp::socket waker(io_, udp::endpoint(asio::ip::address_v4::loopback(), 0));
    waker.send_to(asio::buffer("", 1), address());
    thread_.join();
  }

  udp::endpoint address() const { return socket_.local_endpoint(); }

 private:
  void drain() {
    std::array<std::array<uint8_t, 2048>, 64> buffers;
    std::array<iovec, 64> vectors;
    std::array<mmsghdr, 64> messages{};
    for (size_t i = 0; i < 64; ++i) {
      vectors[i] = {buffers[i].data(), buffers[i].size()};
      messages[i].msg_hdr.msg_iov = &vectors[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    while (!done_) recvmmsg(socket_.native_handle(), messages.data(), 64, MSG_WAITFORONE, nullptr);
  }

  asio::io_context io_;
  udp::socket socket_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

// Frames sent over and over for some time. What a frame costs this thread, of processor time.
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

ordered_json row(const std::string& name, CipherId cipher, size_t datagrams, size_t bytes, double cpu_s) {
  return {{"case", name},
          {"cipher", name_of(cipher)},
          {"datagrams_per_s", static_cast<double>(datagrams) / cpu_s},  // of one core
          {"mbit_per_s", 8e-6 * static_cast<double>(bytes) / cpu_s}};
}

constexpr CipherId kCiphers[] = {CipherId::aes_128_gcm, CipherId::chacha20_poly1305};

Result<std::vector<ordered_json>> seal_alone(const TransportOptions& options) {
  const auto bodies = frame_bodies();
  std::vector<ordered_json> rows;
  for (const CipherId cipher : kCiphers) {
    Seal server(kSession, cipher, kSecrets, Side::server), client(kSession, cipher, kSecrets, Side::client);
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
    rows.push_back(row("seal", cipher, bodies.size(), bytes, both_s - open_of_frame_s));
    rows.push_back(row("open", cipher, bodies.size(), bytes, open_of_frame_s));
  }
  return rows;
}

// Damaged in every place in turn: how fast they are turned away, and that none is taken.
Result<std::vector<ordered_json>> forgeries(const TransportOptions& options) {
  const auto bodies = frame_bodies();
  std::vector<ordered_json> rows;
  for (const CipherId cipher : kCiphers) {
    Seal server(kSession, cipher, kSecrets, Side::server), client(kSession, cipher, kSecrets, Side::client);
    Bytes datagram;
    server.seal(protocol::DatagramKind::frame_slice, bodies.front(), datagram);
    size_t accepted = 0;
    // Beyond the header's first 12 bytes, which are looked at before anything is deciphered.
    const double cpu_s = seconds_per_frame(options.seconds, [&] {
      for (size_t at = 12; at < datagram.size(); ++at) {
        datagram[at] ^= 0x01;
        accepted += client.open(datagram).has_value();
        datagram[at] ^= 0x01;
      }
    });
    const size_t count = datagram.size() - 12;
    rows.push_back(row("forgeries", cipher, count, count * datagram.size(), cpu_s));
    rows.back()["accepted_forgeries"] = accepted;
  }
  return rows;
}

// As a session paces: a frame's datagrams in batches, each sealed when it is due.
constexpr size_t kPacedBatch = 16;

Result<std::vector<ordered_json>> sealed_against_plain(const TransportOptions& options) {
  const auto bodies = frame_bodies();
  Sink sink;
  asio::io_context io;
  auto socket = daemon::DataSocket::open(io, udp::endpoint(asio::ip::address_v4::loopback(), 0));
  if (!socket) return socket.error();
  const auto send = [&](std::span<const Bytes> datagrams) {
    asio::error_code ignored;
    (*socket)->send(datagrams, sink.address(), ignored);
  };
  std::vector<Bytes> plain;
  for (const Bytes& body : bodies) plain.emplace_back(Seal::sealed_size(body.size()), uint8_t{7});

  std::vector<ordered_json> rows;
  for (const CipherId cipher : kCiphers) {
    Seal seal(kSession, cipher, kSecrets, Side::server);
    std::vector<Bytes> batch(kPacedBatch);
    const auto send_sealed = [&] {
      for (size_t first = 0; first < bodies.size(); first += kPacedBatch) {
        const size_t count = std::min(kPacedBatch, bodies.size() - first);
        for (size_t i = 0; i < count; ++i) {
          seal.seal(protocol::DatagramKind::frame_slice, bodies[first + i], batch[i]);
        }
        send(std::span(batch).first(count));
      }
    };
    // In turns, so that both meet the same machine.
    constexpr int kTurns = 20;
    std::vector<double> plain_s, sealed_s, ratios;
    for (int turn = 0; turn < kTurns; ++turn) {
      plain_s.push_back(seconds_per_frame(options.seconds / kTurns / 2, [&] { send(plain); }));
      sealed_s.push_back(seconds_per_frame(options.seconds / kTurns / 2, send_sealed));
      ratios.push_back(sealed_s.back() / plain_s.back());
    }
    rows.push_back(row("plain_sendmmsg", cipher, plain.size(), bytes_of(plain), median(plain_s)));
    rows.back()["cipher"] = "none";
    rows.push_back(row("sealed_paced", cipher, plain.size(), bytes_of(plain), median(sealed_s)));
    rows.back()["cpu_ratio_to_plain"] = median(ratios);
  }
  return rows;
}

}  // namespace

std::vector<TransportCase> seal_cases() {
  return {{"seal", seal_alone}, {"forgeries", forgeries}, {"sealed_paced", sealed_against_plain}};
}

}  // namespace gnomon::bench
