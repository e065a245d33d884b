// A server that runs a script for one client, over TLS, and so can do what a real one never does.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "client/net/address.h"
#include "client/net/trust.h"
#include "daemon/security/certificates.h"
#include "protocol/codec.h"
#include "protocol/messages.h"
#include "protocol/seal.h"

struct ssl_st;
struct ssl_ctx_st;

namespace gnomon::tests {

// The server's end of one connection. Every read waits five seconds at most and then gives nullopt.
class Peer {
 public:
  Peer(int listener, ssl_ctx_st* tls);
  ~Peer();

  std::optional<protocol::Message> read();
  void write(const protocol::Message& message);
  void write_bytes(std::span<const uint8_t> bytes);
  void hang_up();                  // without Bye
  std::string asked_name() const;  // what the client said in TLS whom it wants; "": nothing

  // Fills in session and data port, and sends the Welcome.
  void welcome(protocol::Welcome message);
  std::optional<protocol::CameraUpdate> read_camera();             // repetitions included
  std::optional<protocol::CameraUpdate> read_new_camera();         // skips repetitions
  std::optional<protocol::CameraUpdate> read_camera_by_control();  // skips other messages
  void send_frame_by_control(FrameId frame, const TileMaskView& mask);
  // Those below send to where the last camera came from.
  void send_slice(const protocol::SliceHeader& header, std::span<const uint8_t> payload);
  void send_frame(FrameId frame, const TileMaskView& mask);
  void send_raw(std::span<const uint8_t> datagram);
  void challenge(uint64_t token);
  std::optional<uint64_t> read_path_response();  // the token; skips other datagrams
  bool read_ping();                              // whether the next datagram is a Ping

 private:
  std::optional<protocol::Opened> read_datagram();

  int stream_ = -1;
  ssl_st* tls_ = nullptr;
  int datagrams_ = -1;
  std::vector<uint8_t> client_address_;
  FrameId newest_{0};
  protocol::MessageReader reader_;
  std::unique_ptr<protocol::Seal> seal_;
};

class FakeServer {
 public:
  using Script = std::function<void(Peer&)>;

  enum class Turns { one_after_the_other, at_once };

  // The script runs on threads other than the caller's, once for each of `connections` connections.
  explicit FakeServer(Script script, int connections = 1, const daemon::Identity& identity = usual_identity(),
                      Turns turns = Turns::one_after_the_other);
  ~FakeServer();  // waits for the script's end

  const client::Address& address() const { return address_; }
  static client::Trust trust(const daemon::Identity& identity = usual_identity());  // pins its certificate
  static const daemon::Identity& usual_identity();

 private:
  int listener_;
  ssl_ctx_st* tls_;
  client::Address address_;
  std::thread thread_;
};

// A Welcome for a little scene of `lights` lights.
protocol::Welcome small_welcome(uint16_t width, uint16_t height, size_t lights);

}  // namespace gnomon::tests
