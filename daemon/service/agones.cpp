#include "daemon/service/agones.h"

#include <asio/awaitable.hpp>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/read_until.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>
#include <atomic>
#include <charconv>
#include <cstring>
#include <thread>

#include "common/log.h"
#include "common/within_memory.h"
#include "daemon/service/agones_life.h"

namespace gnomon::daemon {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;
using Call = AgonesLife::Call;

constexpr uint16_t kUsualPort = 9358;
constexpr auto kPatience = 1s;            // with one answer
constexpr size_t kLongestHeader = 16384;  // bytes

const char* path_of(Call call) {
  switch (call) {
    case Call::health: return "/health";
    case Call::ready: return "/ready";
    case Call::shutdown: return "/shutdown";
  }
  return "/";
}

std::string request_of(Call call, uint16_t port) {
  return std::string("POST ") + path_of(call) + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
         "\r\nContent-Type: application/json\r\nContent-Length: 2\r\nConnection: close\r\n\r\n{}";
}

}  // namespace

// Everything but alive_at belongs to the thread.
struct Agones::Talk {
  explicit Talk(uint16_t to) : port(to), wake(io) {
    asio::co_spawn(io, talk(), asio::detached);
    thread = std::thread([this] {
      while (!done_or_dropped("an answer of Agones", [this] { io.run(); })) {
      }
    });
  }

  asio::awaitable<void> talk() {
    asio::error_code ignored;
    while (!life.over()) {
      if (const auto call = life.next(Clock::now(), is_alive())) {
        bool taken = false;
        try {
          taken = co_await is_taken(*call);
        } catch (const std::bad_alloc&) {  // as if nobody had answered
        }
        life.answered(*call, taken, Clock::now());
        tell(*call, taken);
        continue;
      }
      wake.expires_after(std::max<Nanoseconds>(life.wake_at() - Clock::now(), 0ns));
      co_await wake.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    }
  }

  asio::awaitable<bool> is_taken(Call call) {
    const auto socket = std::make_shared<tcp::socket>(io);
    asio::steady_timer deadline(io, kPatience);
    deadline.async_wait([socket](asio::error_code cancelled) {
      asio::error_code ignored;
      if (!cancelled) socket->close(ignored);
    });
    asio::error_code error;
    auto when_done = asio::redirect_error(asio::use_awaitable, error);
    co_await socket->async_connect({asio::ip::address_v4::loopback(), port}, when_done);
    const std::string request = request_of(call, port);
    if (!error) co_await asio::async_write(*socket, asio::buffer(request), when_done);
    std::string answer;
    auto buffer = asio::dynamic_buffer(answer, kLongestHeader);
    if (!error) co_await asio::async_read_until(*socket, buffer, "\r\n\r\n", when_done);
    const size_t status = answer.find(' ');
    const bool is_http = !error && answer.starts_with("HTTP/1.") && status != std::string::npos;
    co_return is_http&& answer.compare(status, 3, " 20") == 0;
  }

  bool is_alive() const {
    const TimePoint at = alive_at;
    return at == TimePoint::max() || Clock::now() - at <= kHung;
  }

  void tell(Call call, bool taken) {
    if (taken && call != Call::health) log::info("Agones was told", {{"what", path_of(call)}});
    if (taken == answers) return;
    answers = taken;
    if (!taken)
      log::warning("Agones' sidecar does not take what it is told", {{"what", path_of(call)}, {"port", port}});
  }

  void go_on(void (AgonesLife::*step)()) {
    asio::post(io, [this, step] {
      (life.*step)();
      wake.cancel();
    });
  }

  const uint16_t port;
  std::atomic<TimePoint> alive_at{TimePoint::max()};
  asio::io_context io{1};
  asio::steady_timer wake;
  AgonesLife life;
  bool answers = true;
  std::thread thread;
};

uint16_t Agones::port_of(const char* text) {
  uint16_t port = 0;
  const char* const end = text ? text + std::strlen(text) : nullptr;
  const auto read = std::from_chars(text, end, port);
  return text && read.ec == std::errc() && read.ptr == end && port != 0 ? port : kUsualPort;
}

Agones::Agones(uint16_t port) : talk_(std::make_unique<Talk>(port)) {}

Agones::~Agones() {
  talk_->io.stop();
  if (talk_->thread.joinable()) talk_->thread.join();
}

void Agones::ready() { talk_->go_on(&AgonesLife::become_ready); }

void Agones::alive(TimePoint at) { talk_->alive_at = at; }

void Agones::leave() {
  talk_->go_on(&AgonesLife::leave);
  talk_->thread.join();
}

}  // namespace gnomon::daemon
