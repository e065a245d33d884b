// What the admin server does for those who come over TCP. It answers only to its own names. Changes need the operators'
// token, and so does what tells of clients, off loopback. Who shows wrong tokens has to wait.
//
// One thread at a time; the caller passes the time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/published.h"
#include "daemon/admin/http_message.h"
#include "daemon/admin/token_backoff.h"
#include "daemon/metrics/metrics.h"
#include "daemon/security/allowed_hosts.h"
#include "daemon/security/tokens.h"

namespace gnomon::daemon {

// The hash of the first line of admin.token_file; nullopt if no token is configured.
using OperatorToken = std::optional<TokenHash>;

class TcpAccess {
 public:
  // `token` and `metrics` outlive this. `socket`: of admin.socket, which answers name; empty if there is none.
  TcpAccess(std::vector<std::string> hosts, std::string socket, const Published<OperatorToken>& token,
            Metrics& metrics)
      : hosts_(std::move(hosts)), socket_(std::move(socket)), token_(token), metrics_(metrics) {}

  // The answer to a request that is refused, which is counted and in the audit log; nullopt if it may go on.
  std::optional<Page> refuse(const HttpRequest& request, TimePoint now);

 private:
  std::optional<Page> refuse_without_token(const HttpRequest& request, TimePoint now);
  Page refused(const HttpRequest& request, Fault fault, int status, const std::string& why);
  std::string or_the_socket() const;

  const AllowedHosts hosts_;
  const std::string socket_;
  const Published<OperatorToken>& token_;
  Metrics& metrics_;
  TokenBackoff backoff_;
};

}  // namespace gnomon::daemon
