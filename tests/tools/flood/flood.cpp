#include "tests/tools/flood/flood.h"

#include <netinet/udp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <asio/ip/udp.hpp>
#include <cstring>
#include <memory>
#include <random>

#include "common/clock.h"

namespace gnomon::tests {
namespace {

using asio::ip::udp;
using namespace std::chrono_literals;

constexpr size_t kKinds = 4;      // of a stranger's junk
constexpr size_t kOfEach = 64;    // different datagrams of each kind
constexpr size_t kCopies = 16;    // of one datagram in a buffer that the kernel cuts
constexpr size_t kMessages = 32;  // buffers in a system call
constexpr uint8_t kSources = 8;   // source addresses: 127.0.0.2 and the next ones
constexpr size_t kMaxSegmented = 65000;

std::vector<uint8_t> noise(std::mt19937_64& random, size_t bytes) {
  std::vector<uint8_t> made(bytes);
  for (uint8_t& byte : made) byte = static_cast<uint8_t>(random());
  return made;
}

// A buffer that the kernel cuts into equal datagrams.
struct Message {
  std::vector<uint8_t> bytes;
  size_t datagrams = 0;
  iovec buffer{};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(uint16_t))> control{};

  explicit Message(const std::vector<uint8_t>& datagram)
      : datagrams(std::clamp<size_t>(kMaxSegmented / datagram.size(), 1, kCopies)) {
    for (size_t i = 0; i < datagrams; ++i) bytes.insert(bytes.end(), datagram.begin(), datagram.end());
    buffer = {bytes.data(), bytes.size()};
  }

  void attach_to(msghdr& header) {
    header = {};
    header.msg_iov = &buffer;
    header.msg_iovlen = 1;
    if (datagrams == 1) return;
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* const size = CMSG_FIRSTHDR(&header);
    size->cmsg_level = SOL_UDP;
    size->cmsg_type = UDP_SEGMENT;
    size->cmsg_len = CMSG_LEN(sizeof(uint16_t));
    const auto segment = static_cast<uint16_t>(bytes.size() / datagrams);
    std::memcpy(CMSG_DATA(size), &segment, sizeof segment);
  }
};

uint64_t take_replies(int socket) {
  std::array<char, 2048> ignored;
  uint64_t replies = 0;
  while (recv(socket, ignored.data(), ignored.size(), MSG_DONTWAIT) >= 0) ++replies;
  return replies;
}

}  // namespace

Datagrams strangers_junk() {
  std::mt19937_64 random(1);
  Datagrams made;
  for (size_t i = 0; i < kOfEach * kKinds; ++i) {
    switch (i % kKinds) {
      case 0: made.push_back(noise(random, 1 + random() % 1200)); break;
      case 1: made.push_back(noise(random, 1 + random() % protocol::kHeaderBytes)); break;
      case 2: made.push_back(noise(random, protocol::kMaxDatagramBytes + 1 + random() % 200)); break;
      default: {
        made.push_back(noise(random, protocol::kHeaderBytes + protocol::kTagBytes + random() % 200));
        const std::span<uint8_t, protocol::kHeaderBytes> header(made.back().data(), protocol::kHeaderBytes);
        protocol::write_header(header, {.session = SessionId{random()}, .sequence = i + 1});
      }
    }
  }
  return made;
}

Datagrams listeners_junk(daemon::TestClient& client) {
  Datagrams made;
  for (uint32_t frame = 1; frame <= kOfEach; ++frame) {
    made.push_back(client.sealed_view(frame, static_cast<float>(frame)));
    client.send_datagram(made.back());
  }
  // Sequence numbers far beyond the client's, so that only the seal can reject the datagrams.
  auto header = *protocol::decode_header(made.back());
  for (size_t i = 0; i < kOfEach; ++i) {
    std::vector<uint8_t> forged = made[i];
    header.sequence += 1000 + i;
    protocol::write_header(std::span<uint8_t, protocol::kHeaderBytes>(forged.data(), protocol::kHeaderBytes),
                           header);
    forged[protocol::kHeaderBytes + i % (forged.size() - protocol::kHeaderBytes)] ^= 0x01;
    made.push_back(std::move(forged));
  }
  return made;
}

Flood::Flood(uint16_t port, Datagrams junk, double per_second)
    : thread_([this, port, per_second, junk = std::move(junk)] { run(port, junk, per_second); }) {}

void Flood::stop() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void Flood::run(uint16_t port, const Datagrams& junk, double per_second) {
  asio::io_context io;
  std::vector<udp::socket> sources;
  for (uint8_t i = 0; i < kSources; ++i) {
    sources.emplace_back(io, udp::endpoint(asio::ip::address_v4({127, 0, 0, static_cast<uint8_t>(2 + i)}), 0));
    sources.back().connect({asio::ip::address_v4::loopback(), port});
  }
  std::vector<Message> messages(junk.begin(), junk.end());
  std::array<mmsghdr, kMessages> batch{};
  const TimePoint start = Clock::now();
  for (size_t next = 0, turn = 0; !stopping_; ++turn) {
    const int socket = sources[turn % kSources].native_handle();
    std::array<size_t, kMessages> datagrams{};
    for (size_t i = 0; i < kMessages; ++i, next = (next + 1) % messages.size()) {
      messages[next].attach_to(batch[i].msg_hdr);
      datagrams[i] = messages[next].datagrams;
    }
    const int took = sendmmsg(socket, batch.data(), kMessages, 0);
    for (int i = 0; i < took; ++i) sent_ += datagrams[static_cast<size_t>(i)];
    replies_ += take_replies(socket);
    if (per_second <= 0) continue;
    const auto due = std::chrono::duration<double>(static_cast<double>(sent_) / per_second);
    std::this_thread::sleep_until(start + std::chrono::duration_cast<Nanoseconds>(due));
  }
  std::this_thread::sleep_for(50ms);  // for datagrams that are under way
  for (udp::socket& source : sources) replies_ += take_replies(source.native_handle());
}

}  // namespace gnomon::tests
