#include "daemon/ctl/admin_client.h"

#include <httplib.h>

namespace gnomon::ctl {
namespace {

using namespace std::chrono_literals;

constexpr auto kConnectTime = 3s;
constexpr auto kPostTime = 10min;  // a scene may have to be read and its light buffers built

std::string without_line_end(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

Result<std::string> text_of(const httplib::Result& answer, const std::string& url) {
  if (!answer) return Error{url + " does not answer: " + httplib::to_string(answer.error())};
  std::string text = without_line_end(answer->body);
  if (answer->status / 100 == 2) return text;
  return Error{text.empty() ? "HTTP status " + std::to_string(answer->status) : text};
}

}  // namespace

AdminClient::AdminClient(std::string url, const std::string& token)
    : url_(std::move(url)), http_(std::make_unique<httplib::Client>(url_)) {
  if (!token.empty()) http_->set_bearer_token_auth(token);
  http_->set_connection_timeout(kConnectTime);
  http_->set_read_timeout(kPostTime);
}

AdminClient::~AdminClient() = default;

Result<nlohmann::json> AdminClient::status() {
  if (!http_->is_valid()) return Error{url_ + " is no address; allowed: http://HOST:PORT"};
  auto text = text_of(http_->Get("/status"), url_);
  if (!text) return text.error();
  auto parsed = nlohmann::json::parse(*text, nullptr, false);
  if (!parsed.is_object()) return Error{url_ + " is not gnomond's admin server"};
  return parsed;
}

Result<std::string> AdminClient::post(const std::string& path, const nlohmann::json& body) {
  if (!http_->is_valid()) return Error{url_ + " is no address; allowed: http://HOST:PORT"};
  return text_of(http_->Post(path, body.dump(), "application/json"), url_);
}

}  // namespace gnomon::ctl
