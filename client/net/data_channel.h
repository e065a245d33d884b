// The data socket of one session: sealed datagrams out, opened ones in.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/net/address.h"
#include "client/net/loop.h"
#include "common/result.h"
#include "protocol/seal.h"

namespace gnomon::client {

struct DataCounters {
  uint64_t sent = 0;
  uint64_t received = 0;        // opened datagrams
  uint64_t received_bytes = 0;  // of these, headers and seals included
  uint64_t rejected = 0;        // not of this session, damaged or replayed
};

// Used on the loop's thread only. Receives only from the server's address. Loss is silent in both directions.
class DataChannel {
 public:
  // The datagram is borrowed for the call. `arrived`: at this machine, however late this thread read it.
  using OnDatagram = std::function<void(const protocol::Opened&, TimePoint arrived)>;

  // `server`: a numeric address.
  static Result<std::unique_ptr<DataChannel>> open(Loop& loop, const Address& server,
                                                   std::unique_ptr<protocol::Seal> seal, OnDatagram on_datagram);
  ~DataChannel();

  // Changes the server's address, for both directions. Error: as of open().
  Result<void> turn_to(const Address& server);

  // The server's sequence number `sequence` was used outside datagrams (Seal::pass).
  void passed(uint64_t sequence);

  void send(protocol::DatagramKind kind, std::span<const uint8_t> body);
  const DataCounters& counters() const;

 private:
  struct State;
  explicit DataChannel(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace gnomon::client
