#include "daemon/admin/tcp_access.h"

#include <algorithm>

#include "daemon/admin/audit.h"

namespace gnomon::daemon {
namespace {

// These name scenes, tenants and clients.
constexpr std::string_view kGuarded[] = {"/status", "/lights"};
constexpr std::string_view kScheme = "Bearer ";

// Compares in a time that does not depend on the token.
bool shows(const HttpRequest& request, const TokenHash& token) {
  const std::string_view header = request.authorization;
  return header.starts_with(kScheme) && is_among(hash_of(header.substr(kScheme.size())), {&token, 1});
}

}  // namespace

std::string TcpAccess::or_the_socket() const {
  return socket_.empty() ? "; admin.socket is not open either" : ", or come through the socket " + socket_;
}

Page TcpAccess::refused(const HttpRequest& request, Fault fault, int status, const std::string& why) {
  metrics_.report(fault);
  audit_refused_over_tcp(request, fault);
  return {.status = status, .body = why + "\n"};
}

std::optional<Page> TcpAccess::refuse(const HttpRequest& request, TimePoint now) {
  if (!hosts_.allows_host(request.host, request.caller.reached)) {
    return refused(request, Fault::admin_host, 403,
                   "this server does not go by the name in Host; admin.hosts lists further ones");
  }
  if (!request.origin.empty() && !hosts_.allows_origin(request.origin, request.caller.reached)) {
    return refused(request, Fault::admin_origin, 403, "pages of other servers may not ask here");
  }
  if (request.changes) return refuse_without_token(request, now);
  const bool guarded =
      std::ranges::find(kGuarded, request.path) != std::end(kGuarded) && !request.caller.on_loopback;
  return guarded ? refuse_without_token(request, now) : std::nullopt;
}

std::optional<Page> TcpAccess::refuse_without_token(const HttpRequest& request, TimePoint now) {
  const OperatorToken token = *token_.get();
  if (!token) {
    return refused(request, Fault::admin_no_token, 403,
                   "over TCP nothing is changed without a token: set admin.token_file" + or_the_socket());
  }
  if (request.authorization.empty()) {
    return refused(request, Fault::admin_no_token, 401,
                   "this needs the token of admin.token_file" + or_the_socket());
  }
  const std::string& network = request.caller.network;
  if (const auto wait = backoff_.wait(network, now)) {
    Page page = refused(request, Fault::admin_backoff, 429, "too many wrong tokens came from your address: wait");
    page.retry_after = *wait;
    return page;
  }
  if (shows(request, *token)) {
    backoff_.right(network);
    return std::nullopt;
  }
  backoff_.wrong(network, now);
  return refused(request, Fault::admin_wrong_token, 401, "this is not the token of admin.token_file");
}

}  // namespace gnomon::daemon
