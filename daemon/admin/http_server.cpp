#include "daemon/admin/http_server.h"

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstring>
#include <thread>

#include "common/within_memory.h"
#include "daemon/admin/http_connection.h"
#include "daemon/admin/http_tls.h"

namespace gnomon::daemon {
namespace {

namespace net = boost::asio;
using net::ip::tcp;
using ErrorCode = boost::system::error_code;
using Generic = net::generic::stream_protocol;
using namespace std::chrono_literals;

constexpr auto kRetryAccept = 100ms;

tcp::endpoint to_tcp(const Generic::endpoint& from) {
  tcp::endpoint to;
  const size_t size = std::min(from.size(), to.capacity());
  std::memcpy(to.data(), from.data(), size);
  to.resize(size);
  return to;
}

net::ip::address plain(const net::ip::address& address) {
  const bool mapped = address.is_v6() && address.to_v6().is_v4_mapped();
  return mapped ? net::ip::make_address_v4(net::ip::v4_mapped, address.to_v6()) : address;
}

// An IPv6 host or home has a /64.
std::string network_of(const net::ip::address& address) {
  if (address.is_v4()) return address.to_string();
  auto bytes = address.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), uint8_t{0});
  return net::ip::address_v6(bytes).to_string() + "/64";
}

std::string text_of(const net::ip::address& address, uint16_t port) {
  const std::string text = address.to_string();
  return (address.is_v6() ? "[" + text + "]" : text) + ":" + std::to_string(port);
}

}  // namespace

struct HttpServer::Impl {
  // A socket that is listened on.
  struct Door {
    net::basic_socket_acceptor<Generic> acceptor;
    net::steady_timer retry;
    bool local;  // of this machine's processes; else TCP
  };

  Impl(Answers to_answer, Metrics& counts) : all(std::move(to_answer), counts) {}

  Result<void> open(Listening& listening);
  Result<void> open_tcp(const std::string& address, uint16_t wanted);
  void accept(Door& door);
  void accept_later(Door& door);
  void take(Door& door, HttpConnection::Socket socket);
  std::optional<Caller> caller_over_tcp(const HttpConnection::Socket& socket) const;
  void make_room();
  void stop();

  HttpConnections all;
  std::unique_ptr<UnixSocket> socket;
  std::shared_ptr<HttpTls> tls;
  uint16_t port = 0;
  std::list<Door> doors;
  std::thread thread;
};

Result<void> HttpServer::Impl::open(Listening& listening) {
  tls = std::move(listening.tls);
  socket = std::move(listening.socket);
  if (socket) {
    net::local::stream_protocol::acceptor acceptor(all.io, net::local::stream_protocol(), socket->take());
    doors.push_back({std::move(acceptor), net::steady_timer(all.io), true});
  }
  return open_tcp(listening.listen, listening.port);
}

Result<void> HttpServer::Impl::open_tcp(const std::string& address, uint16_t wanted) {
  ErrorCode error;
  tcp::acceptor acceptor(all.io);
  const tcp::endpoint local{net::ip::make_address(address, error), wanted};
  if (!error) acceptor.open(local.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(local, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error) {
    return Error{"admin.port: TCP " + address + " port " + std::to_string(wanted) +
                 " cannot be listened on: " + error.message()};
  }
  port = acceptor.local_endpoint().port();
  doors.push_back({std::move(acceptor), net::steady_timer(all.io), false});
  return {};
}

void HttpServer::Impl::accept(Door& door) {
  until_memory_suffices([&] {
    door.acceptor.async_accept([this, &door](ErrorCode error, HttpConnection::Socket accepted) {
      if (error == net::error::operation_aborted) return;
      if (error) return accept_later(door);
      done_or_dropped("a connection to the admin server", [&] { take(door, std::move(accepted)); });
      accept(door);
    });
  });
}

// Most likely there are no file descriptors left. Waiting clients stay in the kernel's queue until some are free.
void HttpServer::Impl::accept_later(Door& door) {
  until_memory_suffices([&] {
    door.retry.expires_after(kRetryAccept);
    door.retry.async_wait([this, &door](ErrorCode cancelled) {
      if (!cancelled) accept(door);
    });
  });
}

void HttpServer::Impl::take(Door& door, HttpConnection::Socket accepted) {
  std::optional<Caller> caller;
  if (!door.local) {
    caller = caller_over_tcp(accepted);
  } else if (auto process = peer_of(accepted.native_handle())) {
    caller = Caller{.process = std::move(process)};
  }
  if (!caller) return;  // it has gone already
  std::make_shared<HttpConnection>(std::move(accepted), std::move(*caller), door.local ? nullptr : tls, all)
      ->begin();
  make_room();
}

std::optional<Caller> HttpServer::Impl::caller_over_tcp(const HttpConnection::Socket& accepted) const {
  ErrorCode error;
  const tcp::endpoint from = to_tcp(accepted.remote_endpoint(error));
  if (error) return std::nullopt;
  const tcp::endpoint to = to_tcp(accepted.local_endpoint(error));
  if (error) return std::nullopt;
  const net::ip::address remote = plain(from.address()), local = plain(to.address());
  return Caller{.process = {},
                .address = text_of(remote, from.port()),
                .network = network_of(remote),
                .reached = {local.to_string(), to.port(), tls != nullptr},
                .on_loopback = remote.is_loopback() && local.is_loopback()};
}

// Connections that wait for our answer are not closed, as the delay is ours.
void HttpServer::Impl::make_room() {
  using State = HttpConnection::State;
  if (all.open.size() <= kMostConnections) return;
  const auto oldest = std::find_if(all.open.begin(), all.open.end(),
                                   [](const HttpConnection* c) { return c->state() != State::answering; });
  if ((*oldest)->state() == State::asking) all.metrics.report(Fault::admin_replaced);
  (*oldest)->close();
}

void HttpServer::Impl::stop() {
  using State = HttpConnection::State;
  all.stopping = true;
  for (Door& door : doors) {
    door.acceptor.close();
    door.retry.cancel();
  }
  for (HttpConnection* connection : std::list(all.open)) {
    const State state = connection->state();
    if (state == State::asking || state == State::leaving) connection->close();
  }
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<HttpServer>> HttpServer::start(Listening listening, Answers answers, Metrics& metrics) {
  auto impl = std::make_unique<Impl>(std::move(answers), metrics);
  if (auto opened = impl->open(listening); !opened) return opened.error();
  for (Impl::Door& door : impl->doors) impl->accept(door);
  impl->thread = std::thread([&io = impl->all.io] {
    while (!done_or_dropped("an event of the admin server", [&] { io.run(); })) {
    }
  });
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::~HttpServer() {
  net::post(impl_->all.io, [&impl = *impl_] { impl.stop(); });
  impl_->all.looking.join();
  impl_->all.changing.join();
  impl_->thread.join();
}

uint16_t HttpServer::port() const { return impl_->port; }

void HttpServer::set_tls(std::shared_ptr<HttpTls> tls) {
  net::post(impl_->all.io, [&impl = *impl_, next = std::move(tls)]() mutable {
    if (impl.tls) impl.tls = std::move(next);
  });
}

}  // namespace gnomon::daemon
