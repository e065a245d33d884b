// The simulated link between real programs: TCP and UDP relayed on loopback, through one Link for each direction.
//
// A client that connects to the relay's address finds the same port numbers there as at the server's, so that the
// data port that Welcome names leads through the relay too. All connections and datagrams share the link.
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <memory>
#include <vector>

#include "tests/tools/netsim/link.h"

namespace gnomon::netsim {

struct RelayOptions {
  std::string listen = "127.0.0.2";  // numeric addresses
  std::string to = "127.0.0.1";
  std::vector<uint16_t> tcp_ports;
  std::vector<uint16_t> udp_ports;
  Schedule up{Phase{}};    // from clients to the server
  Schedule down{Phase{}};  // from the server to clients
  uint64_t seed = 1;
};

struct RelayCounters {
  uint64_t datagrams = 0;
  uint64_t lost = 0;
  uint64_t queue_full = 0;
  uint64_t blocked = 0;
  uint64_t longest = 0;  // longest payload that passed, in bytes
};

// Belongs to the thread that runs the io_context.
class Relay {
 public:
  // The error names the address and port that cannot be opened.
  static Result<std::unique_ptr<Relay>> open(asio::io_context& io, const RelayOptions& options);
  ~Relay();

  const RelayCounters& counters() const;

 private:
  struct State;
  explicit Relay(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace gnomon::netsim
