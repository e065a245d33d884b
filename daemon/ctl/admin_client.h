// A client of a running gnomond's admin server.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"
#include "daemon/ctl/http_exchange.h"

namespace gnomon::ctl {

// Where and as whom to ask.
struct AdminAccess {
  std::string address =
      {};  // "unix:PATH", "http://HOST:PORT" or "https://HOST:PORT"; if empty, the usual one, see below
  std::string token = {};      // what the daemon's admin.token_file holds, for TCP; may be empty
  std::string authority = {};  // PEM file, for https; if empty, the system's
  std::string name = {};       // that its certificate has; if empty, the address's
};

class AdminClient {
 public:
  // Without an address: the first of admin_sockets_to_try() that we may use; where there is none, TCP on loopback at the
  // usual port, where a daemon shows itself and changes nothing without a token.
  explicit AdminClient(AdminAccess access) : access_(std::move(access)) {}

  Result<nlohmann::json> status() { return get("/status"); }
  Result<nlohmann::json> get(const std::string& path);  // an object

  // Returns the answer's text without its final newlines. The error is the daemon's refusal, or says that it does not
  // answer. Blocks until the request is carried out, which may take minutes. The text and the error may be shown on a
  // terminal.
  Result<std::string> post(const std::string& path, const nlohmann::json& body = nlohmann::json::object());

 private:
  Result<std::string> ask(const HttpAsked& asked);

  const AdminAccess access_;
};

}  // namespace gnomon::ctl
