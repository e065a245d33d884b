#include "daemon/admin.h"

#include <civetweb.h>

#include <cstring>

namespace gnomon::daemon {
namespace {

std::string listening_ports(const AdminConfig& config) {
  const bool is_v6 = config.listen.find(':') != std::string::npos;
  return (is_v6 ? "[" + config.listen + "]" : config.listen) + ":" + std::to_string(config.port);
}

const char* reason_of(int status) {
  switch (status) {
    case 200: return "OK";
    case 405: return "Method Not Allowed";
    case 503: return "Service Unavailable";
    default: return "Error";
  }
}

void write(mg_connection* connection, const Page& page, bool with_body) {
  mg_printf(connection,
            "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\nCache-Control: no-store\r\n"
            "Connection: close\r\n\r\n",
            page.status, reason_of(page.status), page.content_type, page.body.size());
  if (with_body) mg_write(connection, page.body.data(), page.body.size());
}

// civetweb's, a C function: `data` is the page's maker.
int answer(mg_connection* connection, void* data) {
  const std::string method = mg_get_request_info(connection)->request_method;
  Page page{405, "text/plain; charset=utf-8", "only GET and HEAD\n"};
  if (method == "GET" || method == "HEAD") page = (*static_cast<std::function<Page()>*>(data))();
  write(connection, page, method != "HEAD");
  return page.status;
}

}  // namespace

Result<std::unique_ptr<Admin>> Admin::start(const AdminConfig& config, Pages pages) {
  std::unique_ptr<Admin> made(new Admin(std::move(pages)));
  const std::string ports = listening_ports(config);
  const char* options[] = {"listening_ports",   ports.c_str(), "num_threads", "4", "request_timeout_ms", "2000",
                           "enable_keep_alive", "no",          nullptr};
  mg_callbacks callbacks{};
  callbacks.log_message = [](const mg_connection* connection, const char* message) {
    if (auto* admin = static_cast<Admin*>(mg_get_user_data(mg_get_context(connection))))
      admin->last_error_ = message;
    return 1;
  };
  mg_init_library(0);
  made->server_ = mg_start(&callbacks, made.get(), options);
  if (!made->server_) return Error{"admin.listen, admin.port: cannot serve HTTP on " + ports};
  mg_server_port bound{};
  if (mg_get_server_ports(made->server_, 1, &bound) == 1) made->port_ = static_cast<uint16_t>(bound.port);
  for (auto& [path, make_page] : made->pages_) {
    mg_set_request_handler(made->server_, (path + "$").c_str(), answer, &make_page);
  }
  return made;
}

Admin::~Admin() {
  if (server_) mg_stop(server_);
  mg_exit_library();
}

}  // namespace gnomon::daemon
