// Frames of the WebSocket protocol (RFC 6455), as a server reads and writes them. Pure: no socket, no clock.
//
// Any bytes give events or a violation. Memory is bounded by the longest message and by what one feed() brings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace gnomon::daemon::web {

enum class Opcode : uint8_t { continuation = 0, text = 1, binary = 2, close = 8, ping = 9, pong = 10 };

// Appends one unfragmented frame, unmasked as a server's frames are.
void append_frame(std::vector<uint8_t>& out, Opcode opcode, std::span<const uint8_t> payload);

// The close codes that are used here (RFC 6455, 7.4.1).
enum class CloseCode : uint16_t {
  normal = 1000,
  going_away = 1001,
  protocol_error = 1002,
  unsupported_data = 1003,
  policy = 1008,
  too_big = 1009,
};
void append_close(std::vector<uint8_t>& out, CloseCode code);

// Why a client's bytes are not accepted. The connection is to be closed with this code.
struct Violation {
  CloseCode code;
  const char* why;
};

// One thread.
class FrameReader {
 public:
  // A message of more than `max_message_bytes` is refused as soon as its header says so.
  explicit FrameReader(size_t max_message_bytes) : max_(max_message_bytes) {}

  void feed(std::span<const uint8_t> bytes);

  struct Event {
    enum class Kind { message, ping, close };  // a binary message; pongs are nobody's business
    Kind kind;
    std::vector<uint8_t> payload;  // of a close: as it came, at most 125 bytes
  };
  // nullopt if nothing further is complete. After a violation or a close the reader is not used any more.
  std::variant<std::optional<Event>, Violation> next();

 private:
  struct Header {
    bool final = false;
    Opcode opcode = Opcode::continuation;
    size_t bytes = 0;          // of the header
    size_t payload_bytes = 0;  // that follow it
    size_t mask_at = 0;
  };
  std::variant<std::optional<Header>, Violation> read_header() const;
  std::optional<Violation> violation_of(const Header& header) const;
  std::vector<uint8_t> take_payload(const Header& header);

  // A client cuts a message into at most so many frames: empty ones cost it little and us some work.
  static constexpr uint32_t kMostFragments = 64;

  size_t max_;
  std::vector<uint8_t> buffer_;
  std::vector<uint8_t> message_;  // the fragments so far
  uint32_t fragments_ = 0;        // 0: no message has begun
};

}  // namespace gnomon::daemon::web
