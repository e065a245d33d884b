// The names under which the admin server may be addressed. A web page of a stranger, in an operator's browser, may name
// us by a host of its own that resolves to our address (DNS rebinding), or post to us from its own origin: its name is
// not one of ours.
//
// Constant after construction. Any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/admin/http_message.h"

namespace gnomon::daemon {

class AllowedHosts {
 public:
  explicit AllowedHosts(std::vector<std::string> configured) : configured_(std::move(configured)) {}

  // `host`: the header, "127.0.0.1:7601". Allowed are localhost and the address at which the caller reached us, with our
  // port, and what is configured: with a port that one, without a port any.
  bool allows_host(std::string_view host, const Caller& caller) const;

  // `origin`: the header, "https://node7:7601". Its scheme must be ours, the rest as for a host.
  bool allows_origin(std::string_view origin, const Caller& caller) const;

 private:
  std::vector<std::string> configured_;
};

}  // namespace gnomon::daemon
