// The operators' HTTP server: a few pages, made anew for each request. Loopback by default; it has no access control.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/result.h"
#include "daemon/config.h"

struct mg_context;

namespace gnomon::daemon {

struct Page {
  int status = 200;
  const char* content_type = "text/plain; charset=utf-8";
  std::string body;
};

class Admin {
 public:
  // Path ("/metrics") -> what makes the page. Called from threads of the HTTP library, several at a time.
  using Pages = std::map<std::string, std::function<Page()>>;

  static Result<std::unique_ptr<Admin>> start(const AdminConfig& config, Pages pages);
  ~Admin();  // waits for requests in progress

  uint16_t port() const { return port_; }

 private:
  explicit Admin(Pages pages) : pages_(std::move(pages)) {}

  Pages pages_;
  std::string last_error_;  // while starting
  mg_context* server_ = nullptr;
  uint16_t port_ = 0;
};

}  // namespace gnomon::daemon
