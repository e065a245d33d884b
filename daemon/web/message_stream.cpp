#include "daemon/web/message_stream.h"

namespace gnomon::daemon::web {
namespace {

constexpr size_t kLengthBytes = 4;

// Whether the bytes are one message with its length field, and nothing else.
bool is_one_message(std::span<const uint8_t> bytes) {
  if (bytes.size() < kLengthBytes) return false;
  uint64_t length = 0;
  for (size_t i = kLengthBytes; i-- > 0;) length = length << 8 | bytes[i];
  return length == bytes.size() - kLengthBytes;
}

}  // namespace

void MessageStream::feed(std::span<const uint8_t> bytes) {
  if (closed_ || failed_) return;
  if (frames_) return frames_->feed(bytes);
  reader_.feed(bytes);
}

Error MessageStream::fail(const Violation& violation) {
  farewell_ = violation.code;
  failed_ = Error{violation.why};
  return *failed_;
}

Result<std::optional<protocol::Message>> MessageStream::next() {
  if (!frames_) return reader_.next();
  if (failed_) return *failed_;
  while (!closed_) {
    auto message = reader_.next();
    if (!message || *message) return message;
    auto read = frames_->next();
    if (const auto* violation = std::get_if<Violation>(&read)) return fail(*violation);
    auto& event = std::get<std::optional<FrameReader::Event>>(read);
    if (!event) break;
    switch (event->kind) {
      case FrameReader::Event::Kind::message:
        if (!is_one_message(event->payload)) {
          return fail({CloseCode::unsupported_data, "a WebSocket message that is not one control message"});
        }
        reader_.feed(event->payload);
        break;
      case FrameReader::Event::Kind::ping: append_frame(replies_, Opcode::pong, event->payload); break;
      case FrameReader::Event::Kind::close:
        closed_ = true;
        append_close(replies_, CloseCode::normal);
        break;
    }
  }
  return std::optional<protocol::Message>();
}

std::vector<uint8_t> MessageStream::framed(std::vector<uint8_t> message) const {
  if (!frames_) return message;
  std::vector<uint8_t> frame;
  frame.reserve(message.size() + 10);
  append_frame(frame, Opcode::binary, message);
  return frame;
}

std::vector<uint8_t> MessageStream::farewell() const {
  std::vector<uint8_t> frame;
  if (frames_ && !closed_) append_close(frame, farewell_);
  return frame;
}

}  // namespace gnomon::daemon::web
