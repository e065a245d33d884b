#include "tests/tools/netsim/relay.h"

#include <map>

#include "tests/tools/netsim/delay_line.h"
#include "tests/tools/netsim/stream_pump.h"

namespace gnomon::netsim {
namespace {

using asio::ip::tcp;
using asio::ip::udp;

constexpr size_t kMaxFlows = 4096;  // clients' addresses at one port; datagrams from further ones are dropped
constexpr int kSocketBufferBytes = 4 << 20;

void enlarge(udp::socket& socket) {
  asio::error_code ignored;
  socket.set_option(asio::socket_base::receive_buffer_size(kSocketBufferBytes), ignored);
  socket.set_option(asio::socket_base::send_buffer_size(kSocketBufferBytes), ignored);
}

}  // namespace

struct Relay::State {
  // One client's flow through a UDP port: the server sees a separate socket for each client.
  struct Flow {
    udp::socket upstream;
    udp::endpoint client;
    std::array<uint8_t, 65536> buffer{};
  };

  struct Port {
    udp::socket socket;
    udp::endpoint server;
    udp::endpoint from{};
    std::array<uint8_t, 65536> buffer{};
    std::map<udp::endpoint, std::shared_ptr<Flow>> flows{};
  };

  State(asio::io_context& context, const RelayOptions& options)
      : io(context),
        up(options.up, options.seed, Clock::now()),
        down(options.down, ~options.seed, Clock::now()),
        line(context) {}

  asio::io_context& io;
  Link up, down;
  DelayLine line;
  RelayCounters counters;
  std::vector<std::shared_ptr<Port>> ports;
  std::vector<std::shared_ptr<tcp::acceptor>> acceptors;
  bool closed = false;

  // Calls `deliver` when the datagram arrives, once for each copy.
  template <class Deliver>
  void pass(Link& link, std::span<const uint8_t> datagram, Deliver deliver) {
    const Fate fate = link.send_datagram(datagram.size(), Clock::now());
    ++counters.datagrams;
    counters.blocked += fate.kind == Fate::Kind::blocked;
    if (fate.copies > 0) counters.longest = std::max<uint64_t>(counters.longest, datagram.size());
    counters.lost += fate.kind == Fate::Kind::lost;
    counters.queue_full += fate.kind == Fate::Kind::queue_full;
    if (fate.copies == 0) return;
    const auto bytes = std::make_shared<std::vector<uint8_t>>(datagram.begin(), datagram.end());
    for (const TimePoint at : fate.arrivals()) {
      line.at(at, [bytes, deliver] { deliver(*bytes); });
    }
  }

  static void receive_from_clients(const std::shared_ptr<State>& self, const std::shared_ptr<Port>& port) {
    port->socket.async_receive_from(asio::buffer(port->buffer), port->from,
                                    [self, port](const asio::error_code& error, size_t count) {
                                      if (self->closed || error == asio::error::operation_aborted) return;
                                      if (!error) from_client(self, port, std::span(port->buffer).first(count));
                                      receive_from_clients(self, port);
                                    });
  }

  static void from_client(const std::shared_ptr<State>& self, const std::shared_ptr<Port>& port,
                          std::span<const uint8_t> datagram) {
    const auto flow = self->flow_of(self, port);
    if (!flow) return;
    self->pass(self->up, datagram, [flow](const std::vector<uint8_t>& bytes) {
      asio::error_code ignored;
      flow->upstream.send(asio::buffer(bytes), 0, ignored);
    });
  }

  std::shared_ptr<Flow> flow_of(const std::shared_ptr<State>& self, const std::shared_ptr<Port>& port) {
    const auto known = port->flows.find(port->from);
    if (known != port->flows.end()) return known->second;
    if (port->flows.size() >= kMaxFlows) return nullptr;
    auto flow = std::make_shared<Flow>(Flow{udp::socket(io), port->from});
    asio::error_code error;
    flow->upstream.connect(port->server, error);
    if (error) return nullptr;
    enlarge(flow->upstream);
    port->flows.emplace(port->from, flow);
    receive_from_server(self, port, flow);
    return flow;
  }

  static void receive_from_server(const std::shared_ptr<State>& self, const std::shared_ptr<Port>& port,
                                  const std::shared_ptr<Flow>& flow) {
    flow->upstream.async_receive(
        asio::buffer(flow->buffer), [self, port, flow](const asio::error_code& error, size_t count) {
          if (self->closed || error == asio::error::operation_aborted) return;
          if (!error) {
            self->pass(self->down, std::span(flow->buffer).first(count),
                       [port, flow](const std::vector<uint8_t>& bytes) {
                         asio::error_code ignored;
                         port->socket.send_to(asio::buffer(bytes), flow->client, 0, ignored);
                       });
          }
          receive_from_server(self, port, flow);
        });
  }

  static void accept(const std::shared_ptr<State>& self, const std::shared_ptr<tcp::acceptor>& acceptor,
                     const tcp::endpoint& server) {
    acceptor->async_accept([self, acceptor, server](const asio::error_code& error, tcp::socket client) {
      if (self->closed || error == asio::error::operation_aborted) return;
      if (!error) connect(self, std::make_shared<tcp::socket>(std::move(client)), server);
      accept(self, acceptor, server);
    });
  }

  static void connect(const std::shared_ptr<State>& self, const std::shared_ptr<tcp::socket>& client,
                      const tcp::endpoint& server) {
    auto upstream = std::make_shared<tcp::socket>(self->io);
    upstream->async_connect(server, [self, client, upstream](const asio::error_code& error) {
      if (error || self->closed) return;
      asio::error_code ignored;
      client->set_option(tcp::no_delay(true), ignored);
      upstream->set_option(tcp::no_delay(true), ignored);
      StreamPump::start(client, upstream, self, self->up, self->line);
      StreamPump::start(upstream, client, self, self->down, self->line);
    });
  }
};

Relay::Relay(std::shared_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<Relay>> Relay::open(asio::io_context& io, const RelayOptions& options) {
  auto state = std::make_shared<State>(io, options);
  asio::error_code error;
  const auto listen = asio::ip::make_address(options.listen, error);
  if (error) return Error{"'" + options.listen + "' is no numeric address"};
  const auto to = asio::ip::make_address(options.to, error);
  if (error) return Error{"'" + options.to + "' is no numeric address"};
  const auto refused = [&](const char* what, uint16_t port) {
    return Error{std::string(what) + " " + options.listen + " port " + std::to_string(port) + ": " +
                 error.message()};
  };
  for (const uint16_t number : options.udp_ports) {
    auto port = std::make_shared<State::Port>(State::Port{udp::socket(io), udp::endpoint(to, number)});
    const udp::endpoint local(listen, number);
    port->socket.open(local.protocol(), error);
    if (!error) port->socket.bind(local, error);
    if (error) return refused("UDP", number);
    enlarge(port->socket);
    state->ports.push_back(port);
  }
  for (const uint16_t number : options.tcp_ports) {
    auto acceptor = std::make_shared<tcp::acceptor>(io);
    const tcp::endpoint local(listen, number);
    acceptor->open(local.protocol(), error);
    if (!error) acceptor->set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor->bind(local, error);
    if (!error) acceptor->listen(asio::socket_base::max_listen_connections, error);
    if (error) return refused("TCP", number);
    state->acceptors.push_back(acceptor);
    State::accept(state, acceptor, tcp::endpoint(to, number));
  }
  for (const auto& port : state->ports) State::receive_from_clients(state, port);
  return std::unique_ptr<Relay>(new Relay(std::move(state)));
}

Relay::~Relay() {
  state_->closed = true;
  asio::error_code ignored;
  for (const auto& port : state_->ports) {
    port->socket.close(ignored);
    for (const auto& [client, flow] : port->flows) flow->upstream.close(ignored);
    port->flows.clear();
  }
  for (const auto& acceptor : state_->acceptors) acceptor->close(ignored);
  state_->line.clear();  // its functions own the state
}

const RelayCounters& Relay::counters() const { return state_->counters; }

}  // namespace gnomon::netsim
