// The operators' HTTP server: a few pages, made anew for each request. Loopback by default; it has no access control.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

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

  static Result<std::unique_ptr<Admin>> start(const AdminConfig& config, const Pages& pages);
  ~Admin();  // waits for requests in progress

  uint16_t port() const { return port_; }

 private:
  Admin();

  std::unique_ptr<httplib::Server> server_;
  uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace gnomon::daemon
