// HTTP/1.1 responses to browsers, as bytes. Pure.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/web/web_request.h"

namespace gnomon::daemon::web {

// Constant, and shared by the responses that it is sent in.
using SharedBytes = std::shared_ptr<const std::vector<uint8_t>>;

struct Response {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> fields = {};  // beside those that every response has
  SharedBytes body = nullptr;                                    // nullptr: empty
  bool close = false;                                            // the connection, afterwards
  std::string script = {};  // what is in the page, as a source of a content security policy: `'sha256-...'`
};

// A response of plain text, which no cache keeps.
Response text_response(int status, const std::string& text);

// Whether an Accept-Encoding takes Brotli.
bool accepts_brotli(std::string_view field);

// The response's header as bytes, with the fields that guard every page: it loads nothing from elsewhere, no other page
// may embed it, and it sends nobody its address. Content-Length is that of the body, which a HEAD is not sent.
// `connects`: to whom the page may connect beside us, as a source of a content security policy.
std::vector<uint8_t> header_of(const Response& response, const std::string& connects = {});

// What follows the header; nullptr if nothing does.
SharedBytes body_for(const Request& request, const Response& response);

}  // namespace gnomon::daemon::web
