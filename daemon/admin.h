// The operators' HTTP server: a few pages, made anew for each request. Loopback by default. Whoever reaches it
// may look; who posts, and so changes something, needs the token where one is configured.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "daemon/config.h"

namespace httplib {
class Server;
}

namespace gnomon::daemon {

struct Page {
  int status = 200;
  const char* content_type = "text/plain; charset=utf-8";
  std::string body;
};

class Admin {
 public:
  // Path ("/metrics") -> what makes the page. Called from the HTTP library's threads, several at a time.
  using Pages = std::map<std::string, std::function<Page()>>;
  // Regular expression of paths that something is posted to ("/scenes/(.+)/lights/([0-9]+)") -> what answers, given the
  // expression's groups and the body, which is JSON. The same.
  using Actions =
      std::map<std::string, std::function<Page(const std::vector<std::string>& groups, const std::string& body)>>;

  // Error: the port is taken, or the token file cannot be read or is too short.
  static Result<std::unique_ptr<Admin>> start(const AdminConfig& config, const Pages& pages,
                                              const Actions& actions = {});
  ~Admin();  // waits for requests in progress

  uint16_t port() const { return port_; }

 private:
  Admin();

  std::unique_ptr<httplib::Server> server_;
  uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace gnomon::daemon
