#include "daemon/net/door_port.h"

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/read_until.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>

#include "common/within_memory.h"

namespace gnomon::daemon {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr auto kPatience = 2s;  // with one that asks
constexpr auto kRetryAccept = 100ms;
constexpr size_t kLongestQuestion = 4096;  // bytes, a probe's HTTP headers included

std::string http(const char* status, const std::string& text) {
  return std::string("HTTP/1.1 ") + status +
         "\r\nContent-Type: text/plain\r\nContent-Length: " + std::to_string(text.size()) +
         "\r\nConnection: close\r\n\r\n" + text;
}

// What is booked of the devices that take sessions; 0 if none does.
double load_of(const std::vector<PooledDevice>& devices) {
  double booked = 0, in_service = 0;
  for (const PooledDevice& device : devices) {
    booked += device.load;
    in_service += device.up && !device.drained;
  }
  return in_service > 0 ? booked / in_service : 0;
}

}  // namespace

Result<std::unique_ptr<DoorPort>> DoorPort::open(const NetShared& shared, asio::io_context& io) {
  const FleetConfig& fleet = shared.config.fleet;
  if (fleet.door_listen.empty()) return std::unique_ptr<DoorPort>();
  std::unique_ptr<DoorPort> made(new DoorPort(shared, io));
  const tcp::endpoint local{asio::ip::make_address(fleet.door_listen), fleet.door_port};
  asio::error_code error;
  made->acceptor_.open(local.protocol(), error);
  if (!error) made->acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) made->acceptor_.bind(local, error);
  if (!error) made->acceptor_.listen(tcp::acceptor::max_listen_connections, error);
  if (error) {
    return Error{"fleet.door_port: TCP " + fleet.door_listen + " port " + std::to_string(fleet.door_port) + ": " +
                 error.message()};
  }
  shared.metrics.operation().expect_door();
  made->port_ = made->acceptor_.local_endpoint(error).port();
  log::info("door port open", {{"address", fleet.door_listen}, {"port", made->port_}});
  return made;
}

void DoorPort::accept() {
  until_memory_suffices([this] {
    acceptor_.async_accept([this](asio::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        done_or_dropped("a door's question", [&] { answer_later(std::move(socket)); });
        return accept();
      }
      until_memory_suffices([this] {  // most likely there are no file descriptors left
        retry_.expires_after(kRetryAccept);
        retry_.async_wait([this](asio::error_code cancelled) {
          if (!cancelled) accept();
        });
      });
    });
  });
}

void DoorPort::answer_later(tcp::socket socket) {
  asio::co_spawn(io_, answer(std::make_shared<tcp::socket>(std::move(socket))), asio::detached);
}

// What is asked ends with a line, or with the empty line of an HTTP request, which is read to its end: closing while
// bytes are unread would reset the connection, and the answer could be lost.
asio::awaitable<void> DoorPort::answer(std::shared_ptr<tcp::socket> socket) {
  asio::steady_timer deadline(io_, kPatience);
  deadline.async_wait([socket](asio::error_code cancelled) {
    asio::error_code ignored;
    if (!cancelled) socket->close(ignored);  // what is read next ends, too
  });
  asio::error_code error;
  auto when_done = asio::redirect_error(asio::use_awaitable, error);
  std::string asked;
  auto buffer = asio::dynamic_buffer(asked, kLongestQuestion);
  co_await asio::async_read_until(*socket, buffer, '\n', when_done);
  const bool is_http = asked.starts_with("GET ");
  if (!error && is_http) co_await asio::async_read_until(*socket, buffer, "\r\n\r\n", when_done);
  if (error) co_return;
  const std::string answer = answer_to(asked);
  co_await asio::async_write(*socket, asio::buffer(answer), when_done);
  if (!error) shared_.metrics.operation().asked_by_door();
}

std::string DoorPort::answer_to(const std::string& asked) {
  if (asked.starts_with("agent")) {
    return std::string(sign_.line(shared_.health.admits(), load_of(shared_.devices.report())));
  }
  if (!asked.starts_with("GET /readyz ")) return http("404 Not Found", "ask for /readyz\n");
  if (shared_.health.serves(Clock::now())) return http("200 OK", "ready\n");
  return http("503 Service Unavailable", "not ready\n");
}

}  // namespace gnomon::daemon
