// A client of a running gnomond's admin HTTP server.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"

namespace httplib {
class Client;
}

namespace gnomon::ctl {

class AdminClient {
 public:
  // `url` as http://HOST:PORT. `token`: what the daemon's admin.token_file holds, for post(); may be empty.
  explicit AdminClient(std::string url, const std::string& token = {});
  ~AdminClient();

  Result<nlohmann::json> status();

  // Returns the answer's text without its final newlines. The error is the daemon's refusal, or says that it does not
  // answer. Blocks until the request is carried out, which may take minutes.
  Result<std::string> post(const std::string& path, const nlohmann::json& body = nlohmann::json::object());

 private:
  std::string url_;
  std::unique_ptr<httplib::Client> http_;
};

}  // namespace gnomon::ctl
