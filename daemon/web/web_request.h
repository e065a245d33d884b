// HTTP/1.1 requests of browsers, from bytes. Pure: no socket, no clock.
//
// Any bytes give a request or a refusal. Memory is bounded by kMaxHeader and by what one feed() brings: requests have no
// bodies, and the next one is read when the one before has been answered.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gnomon::daemon::web {

struct Request {
  enum class Method { get, head, other };

  Method method = Method::other;
  std::string target = {};  // as sent, without what follows a question mark
  bool keep_alive = false;
  // Fields, empty if they are absent.
  std::string host = {}, origin = {}, authorization = {}, tenant = {}, if_none_match = {}, accept_encoding = {};
  // Of a request to go on as a WebSocket.
  bool upgrade = false;  // the fields Connection and Upgrade ask for it
  std::string websocket_key = {}, websocket_version = {}, websocket_protocol = {};
};

// Why bytes are no request: the status that answers them, after which the connection is closed.
struct BadRequest {
  int status = 400;
  const char* why = "";
};

class RequestReader {
 public:
  static constexpr size_t kMaxHeader = 8192;

  void feed(std::span<const uint8_t> bytes);

  // nullopt if no request is complete. After a BadRequest the reader is not used any more.
  std::variant<std::optional<Request>, BadRequest> next();

  size_t size() const { return buffer_.size(); }  // bytes that were fed and are no request yet
  // What followed the last request. Other bytes than requests, if that was one to go on as a WebSocket.
  std::vector<uint8_t> take_rest() { return std::exchange(buffer_, {}); }

 private:
  bool is_worth_a_look();

  std::vector<uint8_t> buffer_;
  size_t searched_ = 0;   // bytes in which the end of the header was looked for
  size_t looked_at_ = 0;  // bytes that the parser had when it looked last
};

}  // namespace gnomon::daemon::web
