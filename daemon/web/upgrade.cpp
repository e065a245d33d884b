#include "daemon/web/upgrade.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "daemon/security/allowed_hosts.h"
#include "daemon/security/digests.h"

namespace gnomon::daemon::web {
namespace {

constexpr const char* kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

// 16 bytes in Base64: 22 characters and two that fill up.
bool is_key(std::string_view key) {
  return key.size() == 24 && key.ends_with("==") && std::all_of(key.begin(), key.end() - 2, [](unsigned char c) {
           return std::isalnum(c) || c == '+' || c == '/';
         });
}

bool offers(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const size_t end = std::min(list.find(','), list.size());
    std::string_view one = list.substr(0, end);
    one.remove_prefix(std::min(one.find_first_not_of(" \t"), one.size()));
    if (one.substr(0, one.find_last_not_of(" \t") + 1) == name) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

std::string accept_of(const std::string& key) {
  const std::string text = key + kGuid;
  const auto digest = sha1({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  return base64(digest);
}

}  // namespace

Response upgrade(const Request& request) {
  if (request.method != Request::Method::get || !request.upgrade || request.websocket_version != "13") {
    Response response = text_response(426, "sessions are spoken by WebSocket, version 13");
    response.fields.insert(response.fields.end(),
                           {{"Connection", "Upgrade"}, {"Upgrade", "websocket"}, {"Sec-WebSocket-Version", "13"}});
    return response;
  }
  if (!is_same_origin(request.origin, request.host, true)) {
    return text_response(403, "pages of other servers may not ask here");
  }
  if (!is_key(request.websocket_key)) return text_response(400, "no Sec-WebSocket-Key");
  if (!offers(request.websocket_protocol, kSubprotocol)) return text_response(400, "the subprotocol is gnomon");
  return {.status = 101,
          .fields = {{"Connection", "Upgrade"},
                     {"Upgrade", "websocket"},
                     {"Sec-WebSocket-Accept", accept_of(request.websocket_key)},
                     {"Sec-WebSocket-Protocol", kSubprotocol}}};
}

}  // namespace gnomon::daemon::web
