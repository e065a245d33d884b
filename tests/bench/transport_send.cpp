// Case of gnomon-bench transport: the cost of sending frames as the daemon does, compared with the same bytes in plain
// sendmmsg calls.
//
// The daemon's side is its own code from an encoded frame on: FrameSender, the session's LinkSender with its pacing and
// its handling of feedback, the seal, and the data socket, with segmentation offload and without. Only the clock is
// simulated, so that nothing waits. The plain side sends complete frames at once. Both sides' datagrams are read by the
// sending thread itself, outside of the measured time, so that no other thread's wake-ups are included.
#include <sys/socket.h>

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>

#include "client/net/arrival_report.h"
#include "daemon/net/frame_sender.h"
#include "tests/bench/report.h"
#include "tests/bench/transport_traffic.h"

namespace gnomon::bench {
namespace {

using asio::ip::udp;
using nlohmann::ordered_json;
using protocol::CipherId;
using protocol::Seal;
using protocol::Side;
using namespace std::chrono_literals;
using Bytes = std::vector<uint8_t>;

constexpr Nanoseconds kFrameInterval = 16667us;
constexpr size_t kPathBytes = 1472;  // Ethernet's; on loopback the MTU search would find longer datagrams
constexpr int kWarmUpFrames = 180;   // enough for the rate to grow and the path's MTU to be found
const udp::endpoint kLoopback(asio::ip::address_v4::loopback(), 0);

// The processor time of a function, without that of the measurement.
class Stopwatch {
 public:
  Stopwatch() {
    std::vector<double> empty;
    for (int i = 0; i < 1000; ++i) {
      const double before = cpu_seconds();
      empty.push_back(cpu_seconds() - before);
    }
    own_ = median(empty);
  }

  template <class Work>
  void measure(Work work) {
    const double before = cpu_seconds();
    work();
    seconds_ += cpu_seconds() - before - own_;
  }

  double take() { return std::exchange(seconds_, 0); }

 private:
  double own_ = 0, seconds_ = 0;
};

// The receiver of the datagrams: on loopback they have arrived when the call that sent them returns.
class Sink {
 public:
  Sink() : socket_(io_, kLoopback) {
    socket_.set_option(asio::socket_base::receive_buffer_size(4 << 20));
    for (size_t i = 0; i < kBatch; ++i) {
      vectors_[i] = {buffers_[i].data(), buffers_[i].size()};
      messages_[i].msg_hdr.msg_iov = &vectors_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }

  udp::endpoint address() const { return socket_.local_endpoint(); }

  // Calls `each(datagram)` for each datagram that has arrived; long ones may be truncated.
  template <class Each>
  void drain(Each each) {
    int got = 0;
    while ((got = recvmmsg(socket_.native_handle(), messages_.data(), kBatch, MSG_DONTWAIT, nullptr)) > 0) {
      for (size_t i = 0; i < static_cast<size_t>(got); ++i)
        each(std::span(buffers_[i]).first(messages_[i].msg_len));
    }
  }

 private:
  static constexpr size_t kBatch = 64;

  asio::io_context io_;
  udp::socket socket_;
  std::array<std::array<uint8_t, protocol::kMaxProbedBytes>, kBatch> buffers_;
  std::array<iovec, kBatch> vectors_;
  std::array<mmsghdr, kBatch> messages_{};
};

Result<std::unique_ptr<daemon::DataSocket>> open_socket(asio::io_context& io, bool segments) {
  auto socket = daemon::DataSocket::open(io, kLoopback);
  if (socket && !segments) (*socket)->do_not_segment();
  return socket;
}

// A session at 60 Hz whose client is near and acknowledges everything that the path carries.
class SealedFlow {
 public:
  SealedFlow(CipherId cipher, daemon::DataSocket& socket)
      : socket_(socket), client_(kBenchSession, cipher, kBenchSecrets, Side::client) {
    auto permit = std::get<daemon::SessionPermit>(limits_.take(TenantId{0}, daemon::ClientNetwork{}));
    auto seal = std::make_unique<Seal>(kBenchSession, cipher, kBenchSecrets, Side::server);
    daemon::SessionGrant grant;
    grant.features = protocol::kFeatureFeedback | protocol::kFeatureParity;
    session_.emplace(
        daemon::SessionParts{
            .id = kBenchSession, .grant = std::move(grant), .seal = std::move(seal), .permit = std::move(permit)},
        now_);
    report();  // the session learns its client's address from it
  }

  Result<void> warm_up() {
    for (int i = 0; i < kWarmUpFrames; ++i) {
      if (auto done = encode(); !done) return done;
      send_frame();
    }
    take_seconds();
    return {};
  }

  void send_frame() {
    datagrams_ = bytes_ = 0;
    frame_.meta.route.frame.value += 1;
    watch_.measure([&] { sender_.add(frame_, *session_, now_); });
    for (const TimePoint next_frame = now_ + kFrameInterval; now_ < next_frame;) {
      watch_.measure([&] {
        sender_.send(*session_, socket_, now_);
        while (session_->under_way().take_ended()) {
        }
      });
      receive();
      if (arrivals_.due_at() <= now_) report();
      now_ = std::max(now_ + 10us, std::min({next_frame, session_->link().wake_at(now_), arrivals_.due_at()}));
    }
  }

  double take_seconds() { return watch_.take(); }
  size_t datagrams() const { return datagrams_; }  // of the last frame
  size_t bytes() const { return bytes_; }
  const std::vector<size_t>& sizes() const { return sizes_; }
  uint64_t lost() { return session_->link().counters().lost; }

 private:
  // Encodes the frame again if the longest slice that the path carries has changed.
  Result<void> encode() {
    const size_t body_bytes = session_->link().slice_body_bytes();
    if (body_bytes == std::exchange(body_bytes_, body_bytes)) return {};
    auto encoded = busy_frame(body_bytes);
    if (!encoded) return encoded.error();
    frame_.slices = std::move(*encoded);
    return {};
  }

  void receive() {
    if (datagrams_ == 0) sizes_.clear();
    sink_.drain([&](std::span<const uint8_t> datagram) {
      if (datagram.size() > kPathBytes) return;
      arrivals_.received(protocol::decode_header(datagram)->sequence, now_);
      sizes_.push_back(datagram.size());
      ++datagrams_;
      bytes_ += datagram.size();
    });
  }

  void report() {
    Bytes body, datagram;
    protocol::append_feedback(body, arrivals_.take(now_));
    client_.seal(protocol::DatagramKind::feedback, body, datagram);
    watch_.measure([&] { session_->receive(datagram, sink_.address(), now_); });
  }

  daemon::DataSocket& socket_;
  Sink sink_;
  Seal client_;
  daemon::SessionLimits limits_{daemon::Config{}};
  std::optional<daemon::Session> session_;
  daemon::FrameSender sender_;
  daemon::EncodedFrame frame_;
  client::ArrivalReport arrivals_;
  Stopwatch watch_;
  TimePoint now_{1s};
  size_t body_bytes_ = 0, datagrams_ = 0, bytes_ = 0;
  std::vector<size_t> sizes_;
};

// Sends datagrams of those sizes, a complete frame at once.
class PlainFlow {
 public:
  PlainFlow(daemon::DataSocket& socket, const std::vector<size_t>& sizes) : socket_(socket) {
    for (const size_t size : sizes) datagrams_.emplace_back(size, uint8_t{7});
  }

  void send_frame() {
    asio::error_code ignored;
    watch_.measure([&] { socket_.send(datagrams_, sink_.address(), ignored); });
    sink_.drain([](std::span<const uint8_t>) {});
  }

  double take_seconds() { return watch_.take(); }

 private:
  daemon::DataSocket& socket_;
  Sink sink_;
  std::vector<Bytes> datagrams_;
  Stopwatch watch_;
};

// This thread's processor seconds for a frame.
template <class Flow>
double seconds_per_frame(std::chrono::duration<double> time, Flow& flow) {
  const auto end = std::chrono::steady_clock::now() + time;
  flow.take_seconds();
  int frames = 0;
  do {
    flow.send_frame();
    ++frames;
  } while (std::chrono::steady_clock::now() < end);
  return flow.take_seconds() / frames;
}

Result<std::vector<ordered_json>> sealed_against_plain(const TransportOptions& options) {
  asio::io_context io;
  auto whole = open_socket(io, false), segmenting = open_socket(io, true);
  if (!whole) return whole.error();
  if (!segmenting) return segmenting.error();
  std::vector<ordered_json> rows;
  for (const CipherId cipher : kCiphers) {
    SealedFlow sealed(cipher, **whole), sealed_gso(cipher, **segmenting);
    for (SealedFlow* flow : {&sealed, &sealed_gso}) {
      if (auto done = flow->warm_up(); !done) return done.error();
    }
    sealed_gso.send_frame();
    PlainFlow plain(**whole, sealed_gso.sizes()), plain_gso(**segmenting, sealed_gso.sizes());
    // Measured alternately, so that all run under the same conditions.
    constexpr int kTurns = 20;
    const auto time = options.seconds / kTurns / 4;
    std::vector<double> plain_s, plain_gso_s, sealed_s, gso_s, ratio, gso_ratio, gso_gain;
    for (int turn = 0; turn < kTurns; ++turn) {
      plain_s.push_back(seconds_per_frame(time, plain));
      plain_gso_s.push_back(seconds_per_frame(time, plain_gso));
      sealed_s.push_back(seconds_per_frame(time, sealed));
      gso_s.push_back(seconds_per_frame(time, sealed_gso));
      ratio.push_back(sealed_s.back() / plain_s.back());
      gso_ratio.push_back(gso_s.back() / plain_s.back());
      gso_gain.push_back(sealed_s.back() / gso_s.back());
    }
    const auto row = [&](const char* name, const char* of, const SealedFlow& flow, const std::vector<double>& s) {
      rows.push_back(traffic_row(name, of, flow.datagrams(), flow.bytes(), median(s)));
      rows.back()["datagrams_per_frame"] = flow.datagrams();
    };
    row("plain_sendmmsg", "none", sealed_gso, plain_s);
    row("sealed_paced_without_gso", name_of(cipher), sealed, sealed_s);
    rows.back()["cpu_ratio_to_plain"] = median(ratio);
    if (!(*segmenting)->segments()) continue;  // this kernel has no segmentation offload
    row("plain_gso", "none", sealed_gso, plain_gso_s);
    row("sealed_paced", name_of(cipher), sealed_gso, gso_s);
    rows.back()["cpu_ratio_to_plain"] = median(gso_ratio);
    rows.back()["gso_cpu_gain"] = median(gso_gain);
    rows.back()["lost_datagrams"] = sealed_gso.lost();
  }
  return rows;
}

}  // namespace

std::vector<TransportCase> send_cases() { return {{"sealed_paced", sealed_against_plain}}; }

}  // namespace gnomon::bench
