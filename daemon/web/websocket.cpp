#include "daemon/web/websocket.h"

#include <utility>

namespace gnomon::daemon::web {
namespace {

constexpr uint8_t kFinal = 0x80, kReserved = 0x70, kMasked = 0x80;
constexpr size_t kMaxControlPayload = 125;  // RFC 6455, 5.5

bool is_control(Opcode opcode) { return static_cast<uint8_t>(opcode) >= 8; }

bool is_known(uint8_t opcode) { return opcode <= 2 || (opcode >= 8 && opcode <= 10); }

void append_big_endian(std::vector<uint8_t>& out, uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

}  // namespace

void append_frame(std::vector<uint8_t>& out, Opcode opcode, std::span<const uint8_t> payload) {
  out.push_back(static_cast<uint8_t>(kFinal | static_cast<uint8_t>(opcode)));
  if (payload.size() < 126) {
    out.push_back(static_cast<uint8_t>(payload.size()));
  } else if (payload.size() < 65536) {
    out.push_back(126);
    append_big_endian(out, payload.size(), 2);
  } else {
    out.push_back(127);
    append_big_endian(out, payload.size(), 8);
  }
  out.insert(out.end(), payload.begin(), payload.end());
}

void append_close(std::vector<uint8_t>& out, CloseCode code) {
  const auto value = static_cast<uint16_t>(code);
  const uint8_t payload[] = {static_cast<uint8_t>(value >> 8), static_cast<uint8_t>(value)};
  append_frame(out, Opcode::close, payload);
}

void FrameReader::feed(std::span<const uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

// What can be told by the header is told before the payload is waited for.
std::optional<Violation> FrameReader::violation_of(const Header& header) const {
  const auto wrong = [](const char* why) { return Violation{CloseCode::protocol_error, why}; };
  if (is_control(header.opcode)) {
    if (!header.final) return wrong("a control frame in fragments");
    if (header.payload_bytes > kMaxControlPayload) return wrong("a control frame of more than 125 bytes");
    return std::nullopt;
  }
  if (header.opcode == Opcode::text) return Violation{CloseCode::unsupported_data, "a text message"};
  if (header.opcode == Opcode::continuation && fragments_ == 0) return wrong("a fragment of no message");
  if (header.opcode == Opcode::binary && fragments_ > 0) return wrong("a message within a message");
  if (header.payload_bytes > max_ - message_.size()) return Violation{CloseCode::too_big, "too long a message"};
  if (fragments_ >= kMostFragments) return Violation{CloseCode::policy, "a message in too many fragments"};
  return std::nullopt;
}

std::variant<std::optional<FrameReader::Header>, Violation> FrameReader::read_header() const {
  if (buffer_.size() < 2) return std::nullopt;
  const uint8_t first = buffer_[0], second = buffer_[1];
  if ((first & kReserved) != 0) return Violation{CloseCode::protocol_error, "a reserved bit is set"};
  if (!is_known(first & 0x0f)) return Violation{CloseCode::protocol_error, "a frame of unknown kind"};
  if ((second & kMasked) == 0) return Violation{CloseCode::protocol_error, "a client's frame without a mask"};
  const uint8_t length = second & 0x7f;
  const size_t extra = length == 126 ? 2 : length == 127 ? 8 : 0;
  if (buffer_.size() < 2 + extra) return std::nullopt;
  uint64_t payload = extra == 0 ? length : 0;
  for (size_t i = 0; i < extra; ++i) payload = payload << 8 | buffer_[2 + i];
  const uint64_t least = extra == 0 ? 0 : extra == 2 ? 126 : 65536;
  if (payload < least || payload >> 63 != 0) {
    return Violation{CloseCode::protocol_error, "a length that is not written as shortly as it can be"};
  }
  return Header{(first & kFinal) != 0, static_cast<Opcode>(first & 0x0f), 2 + extra + 4, payload, 2 + extra};
}

std::vector<uint8_t> FrameReader::take_payload(const Header& header) {
  const auto begin = buffer_.begin() + static_cast<ptrdiff_t>(header.bytes);
  std::vector<uint8_t> payload(begin, begin + static_cast<ptrdiff_t>(header.payload_bytes));
  for (size_t i = 0; i < payload.size(); ++i) payload[i] ^= buffer_[header.mask_at + i % 4];
  buffer_.erase(buffer_.begin(), begin + static_cast<ptrdiff_t>(header.payload_bytes));
  return payload;
}

std::variant<std::optional<FrameReader::Event>, Violation> FrameReader::next() {
  while (true) {
    const auto read = read_header();
    if (const auto* violation = std::get_if<Violation>(&read)) return *violation;
    const auto& header = std::get<std::optional<Header>>(read);
    if (!header) return std::nullopt;
    if (const auto violation = violation_of(*header)) return *violation;
    if (buffer_.size() < header->bytes || buffer_.size() - header->bytes < header->payload_bytes)
      return std::nullopt;
    std::vector<uint8_t> payload = take_payload(*header);
    switch (header->opcode) {
      case Opcode::pong: continue;
      case Opcode::ping: return Event{Event::Kind::ping, std::move(payload)};
      case Opcode::close:
        if (payload.size() == 1) return Violation{CloseCode::protocol_error, "half a close code"};
        return Event{Event::Kind::close, std::move(payload)};
      default: break;
    }
    message_.insert(message_.end(), payload.begin(), payload.end());
    ++fragments_;
    if (!header->final) continue;
    fragments_ = 0;
    return Event{Event::Kind::message, std::exchange(message_, {})};
  }
}

}  // namespace gnomon::daemon::web
