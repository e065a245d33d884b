// A server that shades: takes cameras, streams H.264. For comparison with what Gnomon does; it has one client, keys
// that both got from the same place, and the daemon's own link: pacing, feedback, retransmission, parity and rate.
//
// Two threads: one owns socket and link, the other renders and encodes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "client/cli/latency.h"
#include "protocol/seal.h"
#include "scenes/scene.h"
#include "tests/eval/remote/h264.h"

namespace gnomon::remote {

inline constexpr SessionId kSession{1};

struct ServerOptions {
  scenes::ScenePtr scene;
  std::string device;
  std::string cache;  // folder for light buffers; if empty, none are kept
  H264Options video;  // its bit rate is what the first pictures get; then what the link's controller finds
  protocol::SealSecrets secrets;
  double most_bit_per_s = 0;   // 0: no limit
  protocol::CameraView first;  // rendered before the server listens: the exposure is chosen for it
};

struct ServerFigures {
  uint64_t units = 0;
  uint64_t key_units = 0;
  uint64_t video_bytes = 0;     // before datagrams
  uint64_t datagram_bytes = 0;  // repeated and parity ones included
  client::Latencies render, encode;
};

class RemoteServer {
 public:
  // Listens on 127.0.0.1. Error: no device, no libx264, out of memory.
  static Result<std::unique_ptr<RemoteServer>> start(const ServerOptions& options);
  ~RemoteServer();

  uint16_t port() const;
  // Ends both threads. Error: what went wrong while it ran.
  Result<ServerFigures> stop();

 private:
  struct State;
  explicit RemoteServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace gnomon::remote
