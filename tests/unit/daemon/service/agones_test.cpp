// What a node tells Agones, and that it is told until it is taken. The sidecar is the test's: it answers as
// Agones' documentation has it.
#include "daemon/service/agones.h"

#include <gtest/gtest.h>

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/read_until.hpp>
#include <asio/write.hpp>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "daemon/service/agones_life.h"

namespace gnomon::daemon {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;
using Call = AgonesLife::Call;

constexpr TimePoint kStart{std::chrono::hours(1)};

// ---- the policy, whose clock is the test's

TEST(AgonesLife, SignsOfLifeComeFromTheStartAndReadyWhenItIs) {
  AgonesLife life;
  EXPECT_EQ(life.next(kStart, true), Call::health);
  life.answered(Call::health, true, kStart);
  EXPECT_EQ(life.next(kStart, true), std::nullopt);
  EXPECT_EQ(life.wake_at(), kStart + AgonesLife::kHealthEvery);
  life.become_ready();
  EXPECT_EQ(life.next(kStart + 1s, true), Call::ready);
  life.answered(Call::ready, true, kStart + 1s);
  EXPECT_EQ(life.next(kStart + 1s, true), std::nullopt);
  EXPECT_EQ(life.next(kStart + 2s, true), Call::health);
  life.answered(Call::health, true, kStart + 2s);
  EXPECT_EQ(life.next(kStart + 3s, true), std::nullopt) << "it is said once";
}

TEST(AgonesLife, ReadyIsSaidUntilItIsTakenAndSignsOfLifeGoOn) {
  AgonesLife life;
  life.become_ready();
  TimePoint now = kStart;
  int readies = 0, signs = 0;
  for (; now < kStart + 10s; now += 100ms) {
    while (const auto call = life.next(now, true)) {
      (*call == Call::ready ? readies : signs) += 1;
      life.answered(*call, false, now);
    }
  }
  EXPECT_EQ(readies, 10s / AgonesLife::kRetry);
  EXPECT_EQ(signs, 10s / AgonesLife::kHealthEvery) << "they are not repeated";
}

TEST(AgonesLife, WhatHangsGivesNoSignOfLife) {
  AgonesLife life;
  EXPECT_EQ(life.next(kStart, false), std::nullopt);
  EXPECT_EQ(life.next(kStart + 1s, true), std::nullopt);
  EXPECT_EQ(life.next(kStart + 2s, true), Call::health);
}

TEST(AgonesLife, AGoodbyeIsTheLastThingAndIsNotSaidForEver) {
  AgonesLife life;
  life.become_ready();
  life.answered(Call::ready, false, kStart);
  life.leave();
  EXPECT_EQ(life.next(kStart, true), Call::shutdown) << "at once";
  int said = 1;
  life.answered(Call::shutdown, false, kStart);
  EXPECT_EQ(life.next(kStart, true), std::nullopt);
  EXPECT_EQ(life.wake_at(), kStart + AgonesLife::kRetry);
  for (TimePoint now = kStart; now < kStart + 60s; now += 100ms) {
    const auto call = life.next(now, true);
    if (!call) continue;
    EXPECT_EQ(*call, Call::shutdown);
    life.answered(*call, false, now);
    ++said;
  }
  EXPECT_EQ(said, AgonesLife::kMostGoodbyes);
  EXPECT_TRUE(life.over());
}

TEST(AgonesLife, IsOverWhenItsGoodbyeIsTaken) {
  AgonesLife life;
  life.leave();
  life.answered(*life.next(kStart, true), true, kStart);
  EXPECT_TRUE(life.over());
  EXPECT_EQ(life.next(kStart + 60s, true), std::nullopt);
}

// ---- the talk, by real sockets

constexpr const char* kTaken =
    "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nGrpc-Metadata-Content-Type: application/grpc\r\n"
    "Content-Length: 2\r\nConnection: close\r\n\r\n{}";
constexpr const char* kNotTaken =
    "HTTP/1.1 500 Internal Server Error\r\nContent-Type: application/json\r\nContent-Length: 42\r\n"
    "Connection: close\r\n\r\n{\"code\":2, \"message\":\"no\", \"details\":[]}";

// Answers one request after the other, each as the test says.
class Sidecar {
 public:
  using Answer = std::function<std::string(const std::string& path)>;

  explicit Sidecar(Answer answer, uint16_t port = 0)
      : answer_(std::move(answer)), acceptor_(io_, {asio::ip::address_v4::loopback(), port}) {
    thread_ = std::thread([this] { serve(); });
  }
  ~Sidecar() {
    ending_ = true;
    asio::error_code ignored;
    tcp::socket(io_).connect(acceptor_.local_endpoint(), ignored);  // wakes accept
    thread_.join();
  }
  uint16_t port() const { return acceptor_.local_endpoint().port(); }

  // Blocks until `path` was asked so often.
  void wait_for(const std::string& path, int times) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return std::count(asked_.begin(), asked_.end(), path) >= times; });
  }
  std::vector<std::string> asked() {
    std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  void serve() {
    while (!ending_) {
      tcp::socket socket(io_);
      asio::error_code error;
      acceptor_.accept(socket, error);
      std::string request;
      auto buffer = asio::dynamic_buffer(request);
      const size_t header = asio::read_until(socket, buffer, "\r\n\r\n", error);
      if (error) continue;
      if (request.size() < header + 2)
        asio::read(socket, buffer, asio::transfer_exactly(header + 2 - request.size()), error);
      const std::string path = request.substr(5, request.find(' ', 5) - 5);
      EXPECT_TRUE(request.starts_with("POST /")) << request;
      EXPECT_NE(request.find("\r\nContent-Type: application/json\r\n"), std::string::npos) << request;
      EXPECT_EQ(request.substr(header), "{}");
      asio::write(socket, asio::buffer(answer_(path)), error);
      std::lock_guard lock(mutex_);
      asked_.push_back(path);
      changed_.notify_all();
    }
  }

  const Answer answer_;
  asio::io_context io_;
  tcp::acceptor acceptor_;
  std::atomic<bool> ending_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> asked_;
  std::thread thread_;
};

TEST(Agones, IsToldOfANodesWholeLife) {
  Sidecar sidecar([](const std::string&) { return kTaken; });
  Agones agones(sidecar.port());
  sidecar.wait_for("/health", 1);
  agones.ready();
  sidecar.wait_for("/ready", 1);
  sidecar.wait_for("/health", 2);
  agones.leave();
  const auto asked = sidecar.asked();
  EXPECT_EQ(std::count(asked.begin(), asked.end(), "/ready"), 1);
  EXPECT_EQ(std::count(asked.begin(), asked.end(), "/shutdown"), 1);
  EXPECT_EQ(asked.back(), "/shutdown");
}

TEST(Agones, WhatASidecarDoesNotTakeIsSaidAgain) {
  int readies = 0;
  Sidecar sidecar([&](const std::string& path) -> std::string {
    if (path != "/ready") return kTaken;
    switch (readies++) {
      case 0: return kNotTaken;
      case 1: return "";  // it ends in the middle of an answer
      case 2: return "nonsense\r\n\r\n";
      case 3: return "HTTP/1.1\r\n\r\n";
      default: return kTaken;
    }
  });
  Agones agones(sidecar.port());
  agones.ready();
  sidecar.wait_for("/ready", 5);
  sidecar.wait_for("/health", 3);
  const auto asked = sidecar.asked();
  EXPECT_EQ(std::count(asked.begin(), asked.end(), "/ready"), 5);
}

uint16_t port_of_nobody() {
  return Sidecar([](const std::string&) { return kTaken; }).port();
}

TEST(Agones, ASidecarThatStartsLaterHearsOfIt) {
  const uint16_t port = port_of_nobody();
  Agones agones(port);
  agones.ready();
  Sidecar sidecar([](const std::string&) { return kTaken; }, port);
  sidecar.wait_for("/ready", 1);
}

TEST(Agones, WithoutASidecarANodeEndsAllTheSame) {
  Agones agones(port_of_nobody());
  agones.ready();
  agones.leave();
}

TEST(Agones, APortComesFromTheEnvironment) {
  EXPECT_EQ(Agones::port_of("20358"), 20358);
  for (const char* none : {static_cast<const char*>(nullptr), "", "0", "port", "65536", "9000 ", "-1"})
    EXPECT_EQ(Agones::port_of(none), 9358) << (none ? none : "nullptr");
}

}  // namespace
}  // namespace gnomon::daemon
