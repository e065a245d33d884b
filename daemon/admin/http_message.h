// A request to the admin server, who makes it, and the answer: plain data.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/security/allowed_hosts.h"

namespace gnomon::daemon {

// A process of this machine, as the kernel knows it.
struct PeerCredentials {
  uid_t uid = 0;
  std::vector<gid_t> groups;
};

// `process` is set for those who come through the socket, and only then; the other members are theirs who come over TCP.
struct Caller {
  std::optional<PeerCredentials> process = {};
  std::string address = {};  // "127.0.0.1:40100", "[::1]:40100"
  std::string network = {};  // by which wrong tokens are counted: the IPv4 address, or the /64 of an IPv6 address
  ReachedAt reached = {};
  bool on_loopback = false;  // both ends
};

struct HttpRequest {
  bool changes = false;  // a POST; else a GET or HEAD
  std::string path;      // decoded, without what follows a question mark
  std::string host, origin, content_type, authorization;
  std::string body;
  Caller caller;
};

struct Page {
  int status = 200;
  const char* content_type = "text/plain; charset=utf-8";
  std::string body;
  std::optional<std::chrono::seconds> retry_after = {};
};

}  // namespace gnomon::daemon
