// HTTP/3 (RFC 9114) of one connection as far as a WebTransport session needs it: bytes of streams in, what the client
// asks for out. Pure; QUIC stands below (connection.h).
//
// A client has one session, on the stream of its extended CONNECT (RFC 9220). Its other streams are read and forgotten.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/quic/endpoint.h"

namespace gnomon::daemon::quic {

// Why a connection ends: the error code of HTTP/3 that its client is told.
struct Http3Error {
  uint64_t code = 0;
};

// One thread.
class Http3 {
 public:
  static constexpr size_t kLongestFrame = 8192;  // of those that are read: SETTINGS and HEADERS
  static constexpr size_t kMostStreams = 16;     // of the client's that were not finished

  // What the server's control stream begins with: the stream's type and SETTINGS.
  static std::vector<uint8_t> control_stream();

  // The next bytes of one of the client's streams; `ended`: no further ones come. An error is final.
  std::optional<Http3Error> receive(int64_t stream, std::span<const uint8_t> bytes, bool ended);
  void reset(int64_t stream);  // the client has abandoned it

  // A session that is asked for and was not answered, once.
  std::optional<SessionAsked> take_asked();
  // The stream of the session that was asked for, to be answered with the response's bytes. Precondition: one was.
  int64_t session_stream() const { return *session_; }
  std::vector<uint8_t> response(int status) const;

  bool ended() const { return ended_; }  // the client has ended the session

  // What precedes the payload in the session's datagrams (RFC 9297, 2.1). Precondition: a session was asked for.
  std::vector<uint8_t> datagram_prefix() const;
  // The payload of a datagram of the session; nullopt if it is of none.
  std::optional<std::span<const uint8_t>> payload(std::span<const uint8_t> datagram) const;

 private:
  struct Stream {
    enum class Kind : uint8_t { unknown, control, request, ignored };
    Kind kind = Kind::unknown;
    bool has_settings = false;
    bool has_headers = false;
    uint64_t skip = 0;  // bytes of a frame that is of no interest
    std::vector<uint8_t> unread;
  };

  std::optional<Http3Error> read(int64_t id, Stream& stream);
  std::optional<Http3Error> read_kind(int64_t id, Stream& stream, std::span<const uint8_t>& bytes);
  std::optional<Http3Error> on_frame(int64_t id, Stream& stream, uint64_t type, std::span<const uint8_t> body);
  std::optional<Http3Error> on_headers(int64_t id, Stream& stream, std::span<const uint8_t> section);
  void end(int64_t stream);

  std::map<int64_t, Stream> streams_;
  std::optional<int64_t> session_;
  std::optional<SessionAsked> asked_;
  bool has_control_ = false;
  bool ended_ = false;
};

}  // namespace gnomon::daemon::quic
