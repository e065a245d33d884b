// The admin server: pages that are generated for each request, and actions. It listens on loopback by default. Pages
// are open to everybody who can reach it; actions, which are posted, need the token if one is configured.
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

// The hash of the first line of admin.token_file; nullopt if no token is configured. Error if the file cannot be read,
// others may read it, the token is too short, or the address needs one.
using OperatorToken = std::optional<TokenHash>;
Result<OperatorToken> read_operator_token(const AdminConfig& config);

class Admin {
 public:
  // Path ("/metrics") -> the function that makes the page. Called on the HTTP server's threads, several at a time.
  using Pages = std::map<std::string, std::function<Page()>>;
  // Regular expression of the path of a POST ("/scenes/(.+)/lights/([0-9]+)") -> the function that answers, given the
  // expression's groups and the body, whose Content-Type is JSON. Called on the same threads.
  using Actions =
      std::map<std::string, std::function<Page(const std::vector<std::string>& groups, const std::string& body)>>;

  // Error if the port cannot be opened, or as read_operator_token().
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
