#include "daemon/web/web_response.h"

#include <algorithm>

namespace gnomon::daemon::web {
namespace {

constexpr const char* kScriptPolicy =
    "Content-Security-Policy: default-src 'none'; script-src 'self' 'wasm-unsafe-eval'";
constexpr const char* kPolicy =
    "; worker-src 'self'; style-src 'self'; img-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'none'; "
    "connect-src 'self'";
constexpr const char* kGuards =
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Embedder-Policy: require-corp\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n";

const char* reason(int status) {
  switch (status) {
    case 101: return "Switching Protocols";
    case 200: return "OK";
    case 304: return "Not Modified";
    case 400: return "Bad Request";
    case 401: return "Unauthorized";
    case 403: return "Forbidden";
    case 404: return "Not Found";
    case 405: return "Method Not Allowed";
    case 406: return "Not Acceptable";
    case 413: return "Content Too Large";
    case 421: return "Misdirected Request";
    case 426: return "Upgrade Required";
    case 429: return "Too Many Requests";
    case 431: return "Request Header Fields Too Large";
    case 500: return "Internal Server Error";
    case 503: return "Service Unavailable";
    case 505: return "HTTP Version Not Supported";
  }
  return "Other";
}

}  // namespace

bool accepts_brotli(std::string_view field) {
  while (!field.empty()) {
    const size_t end = std::min(field.find(','), field.size());
    std::string_view one = field.substr(0, end);
    one.remove_prefix(std::min(one.find_first_not_of(" \t"), one.size()));
    const std::string_view coding = one.substr(0, one.find_first_of("; \t"));
    if (coding == "br") return one.find("q=0") == one.npos || one.find("q=0.") != one.npos;
    field.remove_prefix(std::min(end + 1, field.size()));
  }
  return false;
}

Response text_response(int status, const std::string& text) {
  const std::string line = text + "\n";
  return {.status = status,
          .fields = {{"Content-Type", "text/plain; charset=utf-8"}, {"Cache-Control", "no-store"}},
          .body = std::make_shared<const std::vector<uint8_t>>(line.begin(), line.end())};
}

std::vector<uint8_t> header_of(const Response& response, const std::string& connects) {
  std::string text = "HTTP/1.1 " + std::to_string(response.status) + " " + reason(response.status) + "\r\n";
  for (const auto& [name, value] : response.fields) text += name + ": " + value + "\r\n";
  if (response.status != 101) {
    text += kScriptPolicy;
    if (!response.script.empty()) text += " " + response.script;
    text += kPolicy;
    if (!connects.empty()) text += " " + connects;
    text += "\r\n";
    text += kGuards;
    if (response.close) text += "Connection: close\r\n";
    if (response.status != 304) {
      text += "Content-Length: " + std::to_string(response.body ? response.body->size() : 0) + "\r\n";
    }
  }
  text += "\r\n";
  return {text.begin(), text.end()};
}

SharedBytes body_for(const Request& request, const Response& response) {
  const bool empty = !response.body || response.body->empty();
  return empty || request.method == Request::Method::head ? nullptr : response.body;
}

}  // namespace gnomon::daemon::web
