#include "daemon/admin/admin.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <regex>

#include "common/log.h"
#include "daemon/admin/audit.h"
#include "daemon/admin/operators.h"
#include "daemon/security/admin_socket.h"
#include "daemon/security/private_file.h"

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLeastToken = 16;  // characters
constexpr const char* kTokenKey = "admin.token_file";

// A foreign web page in the operator's browser can post here too (cross-site request forgery), but not as JSON.
// Parameters may follow the type.
bool is_json(const HttpRequest& request) {
  std::string type = request.content_type.substr(0, request.content_type.find(';'));
  type.erase(type.find_last_not_of(" \t") + 1);
  std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) { return std::tolower(c); });
  return type == "application/json";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

Result<OperatorToken> read_token(const fs::path& file) {
  if (file.empty()) return OperatorToken();
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

// nullptr if there is to be none.
Result<std::unique_ptr<UnixSocket>> open_socket(const fs::path& configured, std::optional<gid_t> group) {
  if (configured.empty()) return std::unique_ptr<UnixSocket>();
  const bool usual = configured == kUsualAdminSocket;
  const fs::path path = usual ? usual_admin_socket() : configured;
  if (path.empty()) return std::unique_ptr<UnixSocket>();
  std::error_code error;
  if (usual && fs::create_directory(path.parent_path(), error)) {
    fs::permissions(path.parent_path(), fs::perms::owner_all, error);
  }
  auto opened = UnixSocket::listen(path, group);
  if (opened) return opened;
  if (!usual) return Error{"admin.socket: " + opened.error().message};
  log::warning("no socket for operators", {{"why", opened.error().message}});
  return std::unique_ptr<UnixSocket>();
}

}  // namespace

Result<AdminSecrets> read_admin_secrets(const AdminConfig& config) {
  if (auto allowed = check_admin(config); !allowed) return allowed.error();
  const auto token = read_token(config.token_file);
  if (!token) return token.error();
  if (is_loopback(config)) return AdminSecrets{*token, nullptr};
  const auto tls = open_http_tls(config.tls);
  if (!tls) return tls.error();
  return AdminSecrets{*token, *tls};
}

struct Admin::Route {
  std::regex path;
  Action action;
};

Admin::Admin(Pages pages, const Actions& actions) : pages_(std::move(pages)) {
  for (const auto& [path, action] : actions) routes_.push_back({std::regex(path), action});
}

Admin::~Admin() = default;

Result<std::unique_ptr<Admin>> Admin::start(const AdminConfig& config, Pages pages, const Actions& actions,
                                            Metrics& metrics) {
  std::unique_ptr<Admin> made(new Admin(std::move(pages), actions));
  if (auto opened = made->open(config, metrics); !opened) return opened.error();
  return made;
}

Result<void> Admin::open(const AdminConfig& config, Metrics& metrics) {
  const auto secrets = read_admin_secrets(config);
  if (!secrets) return secrets.error();
  token_.publish(secrets->token);
  const auto group = group_of(config.group);
  if (!group) return group.error();
  group_ = *group;
  auto socket = open_socket(config.socket, group_);
  if (!socket) return socket.error();
  if (*socket) socket_ = (*socket)->path();
  over_tcp_ = std::make_unique<TcpAccess>(config.hosts, socket_.string(), token_, metrics);
  const auto refuse = [this](const HttpRequest& request, TimePoint now) {
    return request.caller.process ? std::nullopt : over_tcp_->refuse(request, now);
  };
  const auto get_page = [this](const HttpRequest& request) { return get(request); };
  const auto act = [this](const HttpRequest& request) { return post(request); };
  auto server = HttpServer::start({config.listen, config.port, secrets->tls, std::move(*socket)},
                                  {get_page, act, refuse}, metrics);
  if (!server) return server.error();
  server_ = std::move(*server);
  return {};
}

void Admin::set_secrets(const AdminSecrets& secrets) {
  token_.publish(secrets.token);
  server_->set_tls(secrets.tls);
}

Page Admin::get(const HttpRequest& request) const {
  const auto page = pages_.find(request.path);
  return page == pages_.end() ? Page{.status = 404, .body = "no such page\n"} : page->second();
}

Page Admin::post(const HttpRequest& request) const {
  for (const auto& [path, action] : routes_) {
    std::smatch matches;
    if (!std::regex_match(request.path, matches, path)) continue;
    const std::vector<std::string> groups(std::next(matches.begin()), matches.end());
    const auto& process = request.caller.process;
    if (process && !may_change(*process, group_)) {
      audit_no_operator(request, action.name, joined(groups));
      return {.status = 403,
              .body = "this is for root, for the account of gnomond and for members of admin.group\n"};
    }
    const Page page = is_json(request) ? action.act(groups, request.body)
                                       : Page{.status = 415, .body = "the Content-Type must be application/json\n"};
    audit_action(request, action.name, joined(groups), page);
    return page;
  }
  return {.status = 404, .body = "nothing is done here\n"};
}

}  // namespace gnomon::daemon
