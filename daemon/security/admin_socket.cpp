#include "daemon/security/admin_socket.h"

#include <cstdlib>
#include <string>

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "admin.sock";
constexpr const char* kUnitsFolder = "/run/gnomon";  // RuntimeDirectory= of the packaged unit

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

fs::path usual_admin_socket() {
  const std::string unit = environment("RUNTIME_DIRECTORY"), user = environment("XDG_RUNTIME_DIR");
  if (!unit.empty()) return fs::path(unit.substr(0, unit.find(':'))) / kName;
  if (!user.empty()) return fs::path(user) / "gnomon" / kName;
  return {};
}

std::vector<fs::path> admin_sockets_to_try() {
  std::vector<fs::path> all;
  if (const fs::path usual = usual_admin_socket(); !usual.empty()) all.push_back(usual);
  all.push_back(fs::path(kUnitsFolder) / kName);
  return all;
}

}  // namespace gnomon::daemon
