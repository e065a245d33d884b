#include "tests/system/e2e/daemon.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

namespace gnomon::tests {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSocket = "admin.sock";

std::string with_cache(std::string config) {
  if (config.find("cache_folder") != std::string::npos) return config;
  const std::string device = "device: cpu";
  if (const size_t at = config.find(device); at != std::string::npos) {
    config.insert(at, "cache_folder: " + kept_light_buffers().string() + ", ");
  }
  return config;
}

fs::path write_config(const fs::path& folder, const std::string& text) {
  const fs::path file = folder / "gnomond.yaml";
  std::ofstream(file) << with_cache(text);
  return file;
}

// The whole answer of the server that `connection` is to connect to.
template <class Address>
std::string ask(int connection, const Address& address, const std::string& request) {
  std::string answer;
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    send(connection, request.data(), request.size(), MSG_NOSIGNAL);
    std::array<char, 8192> bytes;
    for (ssize_t count; (count = recv(connection, bytes.data(), bytes.size(), 0)) > 0;) {
      answer.append(bytes.data(), static_cast<size_t>(count));
    }
  }
  close(connection);
  return answer;
}

std::string ask_over_tcp(uint16_t port, const std::string& request) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return ask(socket(AF_INET, SOCK_STREAM, 0), address, request);
}

std::string ask_through_socket(const std::string& path, const std::string& request) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return ask(socket(AF_UNIX, SOCK_STREAM, 0), address, request);
}

std::string headers(uint16_t port) {
  return " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) + "\r\nConnection: close\r\n";
}

std::string get(const client::Address& server, const std::string& path) {
  const std::string answer = ask_over_tcp(server.port, "GET " + path + headers(server.port) + "\r\n");
  const size_t body = answer.find("\r\n\r\n");
  return body == std::string::npos ? "" : answer.substr(body + 4);
}

}  // namespace

fs::path kept_light_buffers() {
  static const fs::path folder = [] {
    if (const char* lent = std::getenv("GNOMON_TEST_LIGHT_BUFFERS")) return fs::path(lent);
    const fs::path bin = GNOMON_BINARY_DIR, all = bin.parent_path() / "light_buffers" / "e2e";
    const auto made = fs::last_write_time(bin / "gnomond").time_since_epoch().count();
    const fs::path own = all / (std::to_string(fs::file_size(bin / "gnomond")) + "_" + std::to_string(made));
    if (!fs::exists(own)) fs::remove_all(all);
    return own;
  }();
  return folder;
}

fs::path living_room_file() {
  return fs::path(GNOMON_BINARY_DIR).parent_path() / "share" / "gnomon" / "scenes" / "living_room.glb";
}

Daemon::Daemon(const std::string& config)
    : process_("gnomond",
               {"--config", write_config(folder_.path(), config).string(), "--set",
                "admin.socket=" + (folder_.path() / kSocket).string()},
               folder_.path()) {
  std::smatch found;
  std::string output;
  eventually([&] {
    output = process_.output();
    return output.find("gnomond ready") != std::string::npos || !process_.running();
  });
  const std::regex ready(R"(gnomond ready control=(\S+) data=(\d+)\S* admin=http://(\S+) pin=(\S+))");
  if (!std::regex_search(output, found, ready)) {
    ADD_FAILURE() << "gnomond did not get ready:\n" << output;
    return;
  }
  control_ = client::parse_address(found[1].str()).value();
  data_port_ = static_cast<uint16_t>(std::stoi(found[2]));
  admin_ = client::parse_address(found[3].str()).value();
  pin_ = found[4].str();
}

void Daemon::rewrite_config(const std::string& text) const { write_config(folder_.path(), text); }

std::string Daemon::page(const std::string& path) const { return get(admin_, path); }

std::string Daemon::post(const std::string& path, const std::string& json) const {
  const std::string request = "POST " + path + headers(admin_.port) +
                              "Content-Type: application/json\r\nContent-Length: " + std::to_string(json.size()) +
                              "\r\n\r\n" + json;
  const std::string answer = ask_through_socket((folder_.path() / kSocket).string(), request);
  return answer.substr(0, answer.find("\r\n"));
}

double Daemon::metric(const std::string& name, const std::vector<std::string>& labels) const {
  std::istringstream lines(page("/metrics"));
  double sum = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(name + "{", 0) != 0 && line.rfind(name + " ", 0) != 0) continue;
    bool all = true;
    for (const auto& label : labels) all = all && line.find(label) != std::string::npos;
    if (all) sum += std::stod(line.substr(line.rfind(' ')));
  }
  return sum;
}

}  // namespace gnomon::tests
