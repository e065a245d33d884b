#include "daemon/admin/admin.h"

#include <fstream>
#include <regex>

#include "daemon/security/private_file.h"

namespace gnomon::daemon {
namespace {

constexpr size_t kLeastToken = 16;  // characters
constexpr const char* kTokenKey = "admin.token_file";

// A foreign web page in the operator's browser can post here too (cross-site request forgery), but not as JSON.
bool is_json(const HttpRequest& request) { return request.content_type.starts_with("application/json"); }

// Compares in a time that does not depend on the token.
bool shows(const HttpRequest& request, const TokenHash& token) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view header = request.authorization;
  return header.starts_with(kScheme) && is_among(hash_of(header.substr(kScheme.size())), {&token, 1});
}

}  // namespace

Result<OperatorToken> read_operator_token(const AdminConfig& config) {
  const std::filesystem::path& file = config.token_file;
  if (file.empty()) {
    if (auto allowed = check_admin(config); !allowed) return allowed.error();
    return OperatorToken();
  }
  if (auto checked = check_private(kTokenKey, file); !checked) return checked.error();
  std::ifstream stream(file);
  std::string token;
  std::getline(stream, token);
  if (token.size() < kLeastToken) {
    return Error{kTokenKey + (": the first line of " + file.string()) + " is shorter than " +
                 std::to_string(kLeastToken) + " characters"};
  }
  return OperatorToken(hash_of(token));
}

struct Admin::Action {
  std::regex path;
  Actions::mapped_type act;
};

Admin::Admin(Pages pages, const Actions& actions) : pages_(std::move(pages)) {
  for (const auto& [path, act] : actions) actions_.push_back({std::regex(path), act});
}

Admin::~Admin() = default;

Result<std::unique_ptr<Admin>> Admin::start(const AdminConfig& config, Pages pages, const Actions& actions,
                                            Metrics& metrics) {
  const auto token = read_operator_token(config);
  if (!token) return token.error();
  std::unique_ptr<Admin> made(new Admin(std::move(pages), actions));
  made->set_token(*token);
  const auto get = [admin = made.get()](const HttpRequest& request) { return admin->get(request); };
  const auto post = [admin = made.get()](const HttpRequest& request) { return admin->post(request); };
  auto server = HttpServer::start(config, {get, post}, metrics);
  if (!server) return server.error();
  made->server_ = std::move(*server);
  return made;
}

Page Admin::get(const HttpRequest& request) const {
  const auto page = pages_.find(request.path);
  return page == pages_.end() ? Page{.status = 404, .body = "no such page\n"} : page->second();
}

Page Admin::post(const HttpRequest& request) const {
  for (const auto& [path, act] : actions_) {
    std::smatch matches;
    if (!std::regex_match(request.path, matches, path)) continue;
    const OperatorToken token = *token_.get();
    if (token && !shows(request, *token)) {
      return {.status = 401, .body = "this needs the token of admin.token_file\n"};
    }
    if (!is_json(request)) return {.status = 415, .body = "the Content-Type must be application/json\n"};
    return act(std::vector<std::string>(std::next(matches.begin()), matches.end()), request.body);
  }
  return {.status = 404, .body = "nothing is done here\n"};
}

}  // namespace gnomon::daemon
