#include "daemon/net/listen_check.h"

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <cstdlib>
#include <string>

namespace gnomon::daemon {
namespace {

template <class Protocol>
asio::error_code try_bind(const std::string& address, uint16_t port) {
  asio::io_context io;
  typename Protocol::socket socket(io);
  const typename Protocol::endpoint local{asio::ip::make_address(address), port};
  asio::error_code error;
  socket.open(local.protocol(), error);
  if (!error) socket.bind(local, error);
  return error == asio::error::address_in_use ? asio::error_code() : error;
}

}  // namespace

std::vector<Error> check_listening(const Config& config) {
  std::vector<Error> errors;
  const ServerConfig& server = config.server;
  const auto add = [&](const std::string& address_key, const std::string& address, const std::string& port_key,
                       uint16_t port, const auto& bind) {
    if (const auto error = bind(address, 0)) {
      errors.push_back(Error{address_key + ": " + address + ": " + error.message()});
    } else if (const auto refused = bind(address, port)) {
      errors.push_back(
          Error{port_key + ": " + address + " port " + std::to_string(port) + ": " + refused.message()});
    }
  };
  // A service manager opens ports for us that we may not open ourselves.
  const bool given = std::getenv("LISTEN_FDS") != nullptr;
  add("server.listen", server.listen, "server.control_port", given ? uint16_t{0} : server.control_port,
      try_bind<asio::ip::tcp>);
  if (errors.empty()) {
    add("server.listen", server.listen, "server.data_port", given ? uint16_t{0} : server.data_port,
        try_bind<asio::ip::udp>);
  }
  if (!config.fleet.door_listen.empty()) {
    add("fleet.door_listen", config.fleet.door_listen, "fleet.door_port", config.fleet.door_port,
        try_bind<asio::ip::tcp>);
  }
  add("admin.listen", config.admin.listen, "admin.port", config.admin.port, try_bind<asio::ip::tcp>);
  return errors;
}

}  // namespace gnomon::daemon
