// The names under which an HTTP server may be addressed. A web page of a stranger, in the browser of somebody whom we
// know, may name us by a host of its own that resolves to our address (DNS rebinding), or ask from its own origin: its
// name is not one of ours.
//
// Constant after construction. Any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon::daemon {

// At which of our addresses a connection came in, and how.
struct ReachedAt {
  std::string address = {};  // "127.0.0.1", "::1"
  uint16_t port = 0;
  bool encrypted = false;
};

class AllowedHosts {
 public:
  explicit AllowedHosts(std::vector<std::string> configured) : configured_(std::move(configured)) {}

  // `host`: the header, "127.0.0.1:7601". Allowed are localhost and the address at which we were reached, with our port,
  // and what is configured: with a port that one, without a port any; "*.lab" stands for each name of one label before
  // ".lab", as in certificates.
  bool allows_host(std::string_view host, const ReachedAt& reached) const;

  // `origin`: the header, "https://node7:7601". Its scheme must be ours, the rest as for a host.
  bool allows_origin(std::string_view origin, const ReachedAt& reached) const;

 private:
  std::vector<std::string> configured_;
};

// Whether a page of `origin` came from the server that it now addresses as `host`: the same scheme, name and port.
bool is_same_origin(std::string_view origin, std::string_view host, bool encrypted);

}  // namespace gnomon::daemon
