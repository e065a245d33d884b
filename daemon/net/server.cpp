#include "daemon/net/server.h"

#include <algorithm>

#include "common/within_memory.h"
#include "daemon/service/supervisor.h"

namespace gnomon::daemon {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr auto kRetryAccept = 100ms;

Result<std::unique_ptr<tcp::acceptor>> listen(asio::io_context& io, const ServerConfig& config) {
  const tcp::endpoint local{asio::ip::make_address(config.listen), config.control_port};
  auto acceptor = std::make_unique<tcp::acceptor>(io);
  asio::error_code error;
  if (const auto given = supervisor::take_socket(supervisor::SocketKind::stream, local.port())) {
    acceptor->assign(local.protocol(), *given, error);
  } else {
    acceptor->open(local.protocol(), error);
    if (!error) acceptor->set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor->bind(local, error);
    if (!error) acceptor->listen(tcp::acceptor::max_listen_connections, error);
  }
  if (!error && local.port() != 0 && acceptor->local_endpoint(error) != local && !error) {
    error = asio::error::address_in_use;  // the service manager's socket is bound to another address
  }
  if (error) {
    return Error{"server.control_port: TCP " + config.listen + " port " + std::to_string(config.control_port) +
                 ": " + error.message()};
  }
  return acceptor;
}

}  // namespace

Server::Server(const NetShared& shared)
    : metrics_(shared.metrics),
      proxies_(shared.config.server.proxies),
      patience_(shared.config.server.handshake_timeout),
      connections_(shared.config.server.max_sessions_per_address, shared.config.server.connections_per_s) {}

Result<std::unique_ptr<Server>> Server::open(const NetShared& shared) {
  std::unique_ptr<Server> made(new Server(shared));
  for (uint32_t i = 0; i < shared.config.server.net_threads; ++i) {
    auto thread = NetThread::open(shared, i);
    if (!thread) return thread.error();
    made->threads_.push_back(std::move(*thread));
  }
  auto acceptor = listen(made->threads_.front()->io(), shared.config.server);
  if (!acceptor) return acceptor.error();
  made->acceptor_ = std::move(*acceptor);
  made->retry_ = std::make_unique<asio::steady_timer>(made->threads_.front()->io());
  made->control_port_ = made->acceptor_->local_endpoint().port();
  auto door = DoorPort::open(shared, made->threads_.front()->io());
  if (!door) return door.error();
  made->door_ = std::move(*door);
  return made;
}

Server::~Server() { stop(); }

void Server::run() {
  accept();
  if (door_) door_->accept();
  for (const auto& thread : threads_) thread->run();
}

void Server::accept() {
  NetThread& owner = *threads_[next_++ % threads_.size()];
  until_memory_suffices([&] {
    acceptor_->async_accept(owner.io(), [this, &owner](asio::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return accept_later(error);
      done_or_dropped("a connection", [&] { take(owner, std::move(socket)); });
      accept();
    });
  });
}

void Server::take(NetThread& owner, tcp::socket socket) {
  asio::error_code gone;
  const auto from = socket.remote_endpoint(gone).address();
  if (gone) return;
  if (proxies_.contains(from)) return take_from_proxy(owner, std::move(socket), from);
  hand_on(owner, std::move(socket), from);
}

// The header is read on the thread that will own the connection; what counts connections belongs to the first one.
void Server::take_from_proxy(NetThread& owner, tcp::socket socket, const asio::ip::address& proxy) {
  read_proxy_greeting(
      std::move(socket), patience_,
      [this, &owner, proxy](tcp::socket greeted, const Result<asio::ip::address>& client) {
        if (!client) {
          return metrics_.report(Fault::proxy_header,
                                 {{"why", client.error().message}, {"address", proxy.to_string()}});
        }
        asio::post(threads_.front()->io(), [this, &owner, client = *client, socket = std::move(greeted)]() mutable {
          done_or_dropped("a connection", [&] { hand_on(owner, std::move(socket), client); });
        });
      });
}

void Server::hand_on(NetThread& owner, tcp::socket socket, const asio::ip::address& client) {
  if (!connections_.take(network_of(client), 1, Clock::now())) {
    return metrics_.report(Fault::connection_rate, {{"address", client.to_string()}});
  }
  owner.adopt(std::move(socket), client);
}

// Most likely there are no file descriptors left. Waiting clients stay in the kernel's queue until some are free.
void Server::accept_later(asio::error_code error) {
  done_or_dropped("a line of the log", [&] {
    log::warning("cannot accept a connection", {{"why", error.message()}});
  });
  until_memory_suffices([this] {
    retry_->expires_after(kRetryAccept);
    retry_->async_wait([this](asio::error_code cancelled) {
      if (!cancelled) accept();
    });
  });
}

void Server::notify(const SessionDegraded& session) { threads_[session.net_thread]->notify(session); }

bool Server::kick(SessionId id, const Kick& kick) {
  return std::any_of(threads_.begin(), threads_.end(), [&](const auto& thread) { return thread->kick(id, kick); });
}

void Server::announce_drain(std::chrono::milliseconds deadline) {
  for (const auto& thread : threads_) thread->announce_drain(deadline);
}

void Server::ask_to_move(bool move) {
  for (const auto& thread : threads_) thread->ask_to_move(move);
}

void Server::announce_lights(const LightsUpdate& update) {
  for (const auto& thread : threads_) thread->announce_lights(update);
}

void Server::close_unwelcome() {
  for (const auto& thread : threads_) thread->close_unwelcome();
}

std::vector<uint16_t> Server::data_ports() const {
  std::vector<uint16_t> ports;
  for (const auto& thread : threads_) ports.push_back(thread->data_port());
  return ports;
}

std::vector<SessionStatus> Server::sessions() const {
  std::vector<SessionStatus> all;
  for (const auto& thread : threads_) {
    const auto sessions = thread->sessions();
    all.insert(all.end(), sessions->begin(), sessions->end());
  }
  return all;
}

void Server::stop() { stop(true); }

void Server::leave() {
  asio::post(threads_.front()->io(), [this] { acceptor_->close(); });
  stop(false);
}

// The first thread stops last, as the acceptor runs on it and hands connections to all.
void Server::stop(bool for_good) {
  for (auto thread = threads_.rbegin(); thread != threads_.rend(); ++thread) (*thread)->stop(for_good);
}

}  // namespace gnomon::daemon
