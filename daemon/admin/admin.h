// The operators' pages: a few, made anew for each request. Loopback by default. Whoever reaches it may look; who
// posts, and so changes something, needs the token where one is configured.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/published.h"
#include "common/result.h"
#include "daemon/admin/http_server.h"
#include "daemon/config/config.h"
#include "daemon/metrics/status.h"
#include "daemon/security/tokens.h"

namespace gnomon::daemon {

// The hash of what stands in the first line of admin.token_file; none: no token is configured. Error: the file cannot
// be read or is read by others, it is too short, or there has to be one.
using OperatorToken = std::optional<TokenHash>;
Result<OperatorToken> read_operator_token(const AdminConfig& config);

class Admin {
 public:
  // Path ("/metrics") -> what makes the page. Called from the HTTP server's threads, several at a time.
  using Pages = std::map<std::string, std::function<Page()>>;
  // Regular expression of paths that something is posted to ("/scenes/(.+)/lights/([0-9]+)") -> what answers, given the
  // expression's groups and the body, which is JSON. The same.
  using Actions =
      std::map<std::string, std::function<Page(const std::vector<std::string>& groups, const std::string& body)>>;

  // Error: the port is taken, or as read_operator_token().
  static Result<std::unique_ptr<Admin>> start(const AdminConfig& config, Pages pages, const Actions& actions,
                                              Metrics& metrics);
  ~Admin();  // waits for requests in progress

  uint16_t port() const { return server_->port(); }
  void set_token(const OperatorToken& token) { token_.publish(token); }  // from the next request on. Any thread

 private:
  struct Action;

  Admin(Pages pages, const Actions& actions);
  Page get(const HttpRequest& request) const;
  Page post(const HttpRequest& request) const;

  const Pages pages_;
  std::vector<Action> actions_;
  Published<OperatorToken> token_;
  std::unique_ptr<HttpServer> server_;
};

}  // namespace gnomon::daemon
