// The admin server: pages that are generated for each request, and actions. Operators of this machine come through a
// socket, where the kernel says who they are; over TCP, on loopback by default, everybody may look, and actions need the
// token. What operators do is in the audit log.
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
#include "daemon/admin/tcp_access.h"
#include "daemon/config/config.h"
#include "daemon/metrics/metrics.h"

namespace gnomon::daemon {

// What a reload reads again.
struct AdminSecrets {
  OperatorToken token;
  std::shared_ptr<HttpTls> tls;  // nullptr on loopback
};

// Error if a file cannot be read, others may read the token or the key, the token is too short, or the address needs
// what is not configured.
Result<AdminSecrets> read_admin_secrets(const AdminConfig& config);

class Admin {
 public:
  // Path ("/metrics") -> the function that makes the page. Called on the HTTP server's threads, several at a time.
  using Pages = std::map<std::string, std::function<Page()>>;
  struct Action {
    const char* name;  // in the audit log; the expression's groups are its target there
    // Given the expression's groups and the body, whose Content-Type is JSON. Called on the same threads.
    std::function<Page(const std::vector<std::string>& groups, const std::string& body)> act;
  };
  // Regular expression of the path of a POST ("/scenes/(.+)/lights/([0-9]+)") -> what is done.
  using Actions = std::map<std::string, Action>;

  // Error if the port or a configured socket cannot be opened, or as read_admin_secrets(). A socket in its usual place
  // that cannot be opened is left out with a warning.
  static Result<std::unique_ptr<Admin>> start(const AdminConfig& config, Pages pages, const Actions& actions,
                                              Metrics& metrics);
  ~Admin();  // waits for requests in progress

  uint16_t port() const { return server_->port(); }
  const std::filesystem::path& socket() const { return socket_; }  // empty if there is none
  void set_secrets(const AdminSecrets& secrets);                   // from the next request on. Any thread

 private:
  struct Route;

  Admin(Pages pages, const Actions& actions);
  Result<void> open(const AdminConfig& config, Metrics& metrics);
  Page get(const HttpRequest& request) const;
  Page post(const HttpRequest& request) const;

  const Pages pages_;
  std::vector<Route> routes_;
  std::optional<gid_t> group_;
  std::filesystem::path socket_;
  Published<OperatorToken> token_;
  std::unique_ptr<TcpAccess> over_tcp_;  // of the server's thread that reads
  std::unique_ptr<HttpServer> server_;
};

}  // namespace gnomon::daemon
