#include "client/net/data_channel.h"

#include <array>
#include <asio/ip/udp.hpp>

#include "client/net/arrival_stamp.h"

namespace gnomon::client {
namespace {

using asio::ip::udp;

// A frame arrives as a burst of some hundred datagrams; the kernel may grant less.
constexpr int kReceiveBufferBytes = 4 << 20;
// Sockets take turns after this many datagrams, so that a busy session does not hold up its neighbours.
constexpr int kDatagramsPerTurn = 64;

Error no_socket(const Address& server, const asio::error_code& error) {
  return Error{"cannot open a data socket to " + to_string(server) + ": " + error.message()};
}

}  // namespace

struct DataChannel::State : std::enable_shared_from_this<State> {
  State(Loop& loop, OnDatagram handler) : socket(loop.context()), on_datagram(std::move(handler)) {}

  udp::socket socket;
  OnDatagram on_datagram;
  std::unique_ptr<protocol::Seal> seal;
  std::vector<uint8_t> outgoing;
  std::array<uint8_t, protocol::kMaxProbedBytes + 1> incoming{};
  DataCounters counters;
  bool closed = false;

  void wait() {
    socket.async_wait(udp::socket::wait_read, [self = shared_from_this()](const asio::error_code& error) {
      if (self->closed || error == asio::error::operation_aborted) return;
      self->receive_ready();
      if (!self->closed) self->wait();
    });
  }

  void receive_ready() {
    for (int i = 0; i < kDatagramsPerTurn && !closed; ++i) {
      const auto got = receive_stamped(socket.native_handle(), incoming);
      if (got.nothing) return;
      if (got.bytes == 0) continue;  // an earlier datagram met a closed port: the server may come back
      accept(std::span(incoming).first(got.bytes), got.arrived);
    }
  }

  void accept(std::span<const uint8_t> datagram, TimePoint arrived) {
    const auto opened = seal->open(datagram);
    if (!opened) {
      ++counters.rejected;
      return;
    }
    ++counters.received;
    counters.received_bytes += datagram.size();
    on_datagram(*opened, arrived);
  }
};

Result<std::unique_ptr<DataChannel>> DataChannel::open(Loop& loop, const Address& server,
                                                       std::unique_ptr<protocol::Seal> seal,
                                                       OnDatagram on_datagram) {
  auto state = std::make_shared<State>(loop, std::move(on_datagram));
  state->seal = std::move(seal);
  asio::error_code error;
  if (const auto address = asio::ip::make_address(server.host, error); !error) {
    state->socket.connect(udp::endpoint(address, server.port), error);
  }
  if (!error) state->socket.non_blocking(true, error);
  if (error) return no_socket(server, error);
  asio::error_code ignored;
  state->socket.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), ignored);
  stamp_arrivals(state->socket.native_handle());
  state->wait();
  return std::unique_ptr<DataChannel>(new DataChannel(std::move(state)));
}

DataChannel::~DataChannel() {
  state_->closed = true;
  asio::error_code ignored;
  state_->socket.close(ignored);
}

Result<void> DataChannel::turn_to(const Address& server) {
  asio::error_code error;
  const auto address = asio::ip::make_address(server.host, error);
  if (!error) state_->socket.connect(udp::endpoint(address, server.port), error);
  if (error) return no_socket(server, error);
  return {};
}

void DataChannel::passed(uint64_t sequence) { state_->seal->pass(sequence); }

void DataChannel::send(protocol::DatagramKind kind, std::span<const uint8_t> body) {
  state_->seal->seal(kind, body, state_->outgoing);
  asio::error_code ignored;  // a loss, as on the path
  state_->socket.send(asio::buffer(state_->outgoing), 0, ignored);
  ++state_->counters.sent;
}

const DataCounters& DataChannel::counters() const { return state_->counters; }

}  // namespace gnomon::client
