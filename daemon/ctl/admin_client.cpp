#include "daemon/ctl/admin_client.h"

#include <unistd.h>

#include "common/printable.h"
#include "daemon/security/admin_socket.h"

namespace gnomon::ctl {
namespace {

using namespace std::chrono_literals;
using Kind = AdminAddress::Kind;

constexpr auto kPostTime = 10min;  // a scene may have to be read and its light buffers built
constexpr const char* kUsualPort = "7601";

std::string without_line_end(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::string printable_lines(const std::string& text) { return without_controls(text, "\n"); }

AdminAddress usual_address() {
  for (const auto& path : daemon::admin_sockets_to_try()) {
    if (access(path.c_str(), R_OK | W_OK) == 0) return {Kind::unix_socket, path.string()};
  }
  return {Kind::http, "127.0.0.1", kUsualPort};
}

// What somebody can do who named no address and got no answer.
std::string advice() {
  std::string tried;
  for (const auto& path : daemon::admin_sockets_to_try()) tried += (tried.empty() ? "" : " or ") + path.string();
  return "\nThere is no socket at " + tried +
         " that we may use either. Does gnomond run, and may this account use its admin.socket? --admin names "
         "another "
         "one (unix:PATH) or an address (http://HOST:PORT, https://HOST:PORT)";
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

}  // namespace

Result<std::string> AdminClient::ask(const HttpAsked& asked) {
  const bool usual = access_.address.empty();
  const auto address = usual ? Result<AdminAddress>(usual_address()) : parse_admin_address(access_.address);
  if (!address) return address.error();
  HttpAsked shown = asked;
  if (address->kind == Kind::unix_socket) shown.token.clear();
  if (address->kind == Kind::http && !shown.token.empty() && !is_loopback(address->host)) {
    return Error{address->text() + ": the token would cross in clear; allowed: https://HOST:PORT"};
  }
  const auto answer = exchange(*address, shown, {access_.authority, access_.name}, kPostTime);
  if (!answer) {
    const bool by_default = usual && address->kind != Kind::unix_socket;
    return Error{address->text() + " does not answer: " + answer.error().message + (by_default ? advice() : "")};
  }
  std::string text = without_line_end(answer->body);
  if (answer->status / 100 == 2) return text;
  return Error{text.empty() ? "HTTP status " + std::to_string(answer->status) : printable_lines(text)};
}

Result<nlohmann::json> AdminClient::get(const std::string& path) {
  const auto text = ask({.path = path, .token = access_.token, .body = {}});
  if (!text) return text.error();
  auto parsed = nlohmann::json::parse(*text, nullptr, false);
  if (!parsed.is_object()) return Error{"what answers is not gnomond's admin server"};
  return parsed;
}

Result<std::string> AdminClient::post(const std::string& path, const nlohmann::json& body) {
  const auto text = ask({.changes = true, .path = path, .token = access_.token, .body = body.dump()});
  return text ? Result<std::string>(printable_lines(*text)) : text;
}

}  // namespace gnomon::ctl
