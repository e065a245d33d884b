// One HTTP request to a daemon's admin server and its answer: over TCP, over TLS, or through a socket in the file system.
#pragma once

#include <chrono>
#include <string>

#include "common/result.h"

namespace gnomon::ctl {

// Where an admin server is.
struct AdminAddress {
  enum class Kind { unix_socket, http, https };

  Kind kind = Kind::http;
  std::string host;  // of TCP; of a socket, its path
  std::string port = {};

  std::string text() const;  // as it is written for --admin
};

// "unix:/run/gnomon/admin.sock", "http://127.0.0.1:7601", "https://node7:7601", "http://[::1]:7601".
Result<AdminAddress> parse_admin_address(const std::string& text);

struct HttpAsked {
  bool changes = false;  // a POST; else a GET
  std::string path;      // as it is; bytes that a URL may not have are encoded on the way
  std::string token;     // shown where it is not empty
  std::string body;      // JSON
};

struct HttpAnswer {
  int status = 0;
  std::string body;
};

// Whose certificate is good, for https.
struct HttpTrust {
  std::string authority;  // a PEM file of those who sign it; if empty, those that the system trusts
  std::string name;       // whose it is; if empty, the address's host
};

// Blocks until the answer is complete. The error says what failed; the address is not in it.
Result<HttpAnswer> exchange(const AdminAddress& address, const HttpAsked& asked, const HttpTrust& trust,
                            std::chrono::milliseconds longest);

}  // namespace gnomon::ctl
