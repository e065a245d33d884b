#include "daemon/admin.h"

#include <httplib.h>

#include <fstream>
#include <optional>

#include "daemon/private_file.h"
#include "daemon/tokens.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr size_t kThreads = 4;
constexpr size_t kMaxRequestBody = 4096;
constexpr auto kRequestTime = 1s;   // for a client to say what it wants
constexpr size_t kLeastToken = 16;  // characters
constexpr const char* kTokenKey = "admin.token_file";

void limit(httplib::Server& server) {
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server.set_payload_max_length(kMaxRequestBody);
  server.set_read_timeout(kRequestTime);
  server.set_write_timeout(kRequestTime);
  server.set_keep_alive_max_count(1);
  // The library would share the port with whoever else listens on it.
  server.set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
}

void answer(httplib::Response& response, Page page) {
  response.status = page.status;
  response.set_header("Cache-Control", "no-store");
  response.set_header("X-Content-Type-Options", "nosniff");
  // The page needs nothing from elsewhere, and nobody else may show it.
  response.set_header("Content-Security-Policy",
                      "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
                      "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  response.set_content(std::move(page.body), page.content_type);
}

// A web page of a stranger that the operator's browser shows may post here too, but not as JSON.
bool is_json(const httplib::Request& request) {
  return request.get_header_value("Content-Type").rfind("application/json", 0) == 0;
}

// The hash of what stands in the file's first line; none: no token is configured.
Result<std::optional<TokenHash>> read_token(const std::filesystem::path& file) {
  if (file.empty()) return std::optional<TokenHash>();
  if (auto checked = check_private(kTokenKey, file); !checked) return checked.error();
  std::ifstream stream(file);
  std::string token;
  std::getline(stream, token);
  if (token.size() < kLeastToken) {
    return Error{kTokenKey + (": the first line of " + file.string()) + " is shorter than " +
                 std::to_string(kLeastToken) + " characters"};
  }
  return std::optional(hash_of(token));
}

// How long that takes says nothing of the token.
bool shows(const httplib::Request& request, const TokenHash& token) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string header = request.get_header_value("Authorization");
  return header.starts_with(kScheme) &&
         is_among(hash_of(std::string_view(header).substr(kScheme.size())), {&token, 1});
}

void demand_token(httplib::Response& response) {
  response.set_header("WWW-Authenticate", "Bearer");
  answer(response, {401, "text/plain", "this needs the token of admin.token_file\n"});
}

}  // namespace

Admin::Admin() : server_(std::make_unique<httplib::Server>()) {}

Result<std::unique_ptr<Admin>> Admin::start(const AdminConfig& config, const Pages& pages, const Actions& actions) {
  const auto token = read_token(config.token_file);
  if (!token) return token.error();
  std::unique_ptr<Admin> made(new Admin);
  limit(*made->server_);
  for (const auto& [path, make_page] : pages) {
    made->server_->Get(path, [make = make_page](const httplib::Request&, httplib::Response& response) {
      answer(response, make());
    });
  }
  for (const auto& [path, act] : actions) {
    made->server_->Post(
        path, [act = act, token = *token](const httplib::Request& request, httplib::Response& response) {
          if (token && !shows(request, *token)) return demand_token(response);
          if (!is_json(request))
            return answer(response, {415, "text/plain", "the Content-Type must be application/json\n"});
          const std::vector<std::string> groups(std::next(request.matches.begin()), request.matches.end());
          answer(response, act(groups, request.body));
        });
  }
  const bool any = config.port == 0;
  const int port = any ? made->server_->bind_to_any_port(config.listen)
                       : (made->server_->bind_to_port(config.listen, config.port) ? config.port : -1);
  if (port <= 0) {
    return Error{"admin.port: TCP " + config.listen + " port " + std::to_string(config.port) +
                 " cannot be listened on: " + std::strerror(errno)};
  }
  made->port_ = static_cast<uint16_t>(port);
  made->thread_ = std::thread([&server = *made->server_] { server.listen_after_bind(); });
  while (!made->server_->is_running()) std::this_thread::sleep_for(1ms);  // before that, stop() is not heard
  return made;
}

Admin::~Admin() {
  if (!thread_.joinable()) return;
  server_->stop();
  thread_.join();
}

}  // namespace gnomon::daemon
