// WebTransport's server side (QUIC, HTTP/3, datagrams) for browsers: packets and time in, packets and events out. No
// socket and no clock. How a connection becomes a session: SessionAsked -> accept() -> Datagram ..., send() -> Closed.
//
// Everything that strangers send is judged here. Until a connection's session is accepted it is half open: there are
// few of these, for a short time, and who wants one beyond a threshold first shows that it receives packets (Retry).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/clock.h"
#include "common/result.h"
#include "daemon/security/certificates.h"

namespace gnomon::daemon::quic {

// A sockaddr_in or sockaddr_in6, as the system has it.
struct Address {
  std::array<uint8_t, 28> bytes{};
  uint32_t size = 0;
  friend bool operator==(const Address&, const Address&) = default;
};

using ConnectionId = uint64_t;  // counts this endpoint's connections from 1

struct Packet {
  Address to;
  std::vector<uint8_t> bytes;
};

// A browser asks for a WebTransport session. Origin is that of the page which asks; empty if it says none.
struct SessionAsked {
  std::string authority, path, origin;
};
struct Datagram {
  std::vector<uint8_t> bytes;
};
// What became of a datagram that was sent. One that was called lost may arrive nevertheless.
struct Outcome {
  uint64_t number = 0;
  bool arrived = false;
};
struct Room {};    // send() has refused a datagram, and may take it now
struct Closed {};  // the last event of a connection whose session was accepted

struct Event {
  ConnectionId connection = 0;
  std::variant<SessionAsked, Datagram, Outcome, Room, Closed> what;
};

struct Limits {
  size_t connections = 1024;
  size_t half_open = 64;
  size_t retry_above = 16;                         // half-open ones: then an address has to be validated
  double unvalidated_per_s = 50;                   // likewise beyond this, with as many at once
  size_t per_network = 64;                         // of an IPv4 address or a /64 of IPv6
  double per_network_per_s = 100;                  // handshakes in the long run; per_network of them at once
  Nanoseconds patience = std::chrono::seconds(3);  // until the session is accepted
  Nanoseconds silence = std::chrono::seconds(10);  // then a connection is dropped
};

struct Options {
  Identity identity;  // PEM: the certificate with its chain, and its key
  Address local;      // of the socket
  Limits limits;
};

// One thread.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  // Of new connections; those that stand keep theirs. The one before stays if this cannot be used.
  virtual Result<void> set_identity(const Identity& identity) = 0;

  virtual void receive(std::span<const uint8_t> packet, const Address& from, TimePoint now) = 0;
  // To be called at wake_at(), which is TimePoint::max() if nothing waits.
  virtual void expire(TimePoint now) = 0;
  virtual TimePoint wake_at() const = 0;

  // What has happened and what is to be sent since the last call; after each of the calls here.
  virtual std::vector<Event> take_events() = 0;
  virtual std::vector<Packet> take_packets(TimePoint now) = 0;

  // Answer SessionAsked. `status`: of HTTP; the connection is closed.
  virtual void accept(ConnectionId id, TimePoint now) = 0;
  virtual void refuse(ConnectionId id, int status, TimePoint now) = 0;

  // Sends one datagram of at most kMostDatagramBytes, `head` and `body` together; Outcome tells of its number. False
  // if the path takes no more for now: Room follows. Of a connection that is gone, true: the datagram is lost.
  virtual bool send(ConnectionId id, uint64_t number, std::span<const uint8_t> head, std::span<const uint8_t> body,
                    TimePoint now) = 0;
  virtual void close(ConnectionId id, TimePoint now) = 0;

  virtual size_t connections() const = 0;
  virtual size_t half_open() const = 0;
};

// A UDP payload of 1,200 bytes, which every path of QUIC takes, less what QUIC and HTTP/3 add at most: first byte,
// connection id (20), packet number (4), tag (16), the frame's type and length (3), the session's number (4).
inline constexpr size_t kMostDatagramBytes = 1200 - 1 - 20 - 4 - 16 - 3 - 4;

// Whether the first byte of a UDP payload may begin a QUIC packet (RFC 9000, 17: the fixed bit). Gnomon's own datagrams
// begin with their version, 2.
inline bool is_quic(std::span<const uint8_t> datagram) { return !datagram.empty() && (datagram[0] & 0x40) != 0; }

// Error if the program was built without WebTransport, or the identity cannot be used.
Result<std::unique_ptr<Endpoint>> make_endpoint(const Options& options);
bool is_built_in();

}  // namespace gnomon::daemon::quic
