#include "daemon/net/demo_certificate.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "daemon/security/certificates.h"

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLasts = 10 * 365 * 24h;  // long, so that a demo does not fail on a forgotten expiry date

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

// The file appears under its name once it is complete, unless another process has made it first, which is no error.
Result<void> write_once(const fs::path& file, const std::string& text, mode_t mode) {
  std::string name = file.string() + ".XXXXXX";
  const int made = mkstemp(name.data());  // 0600
  if (made < 0) return Error{file.string() + ": cannot be written: " + std::strerror(errno)};
  const bool written = fchmod(made, mode) == 0 && write(made, text.data(), text.size()) == ssize_t(text.size());
  close(made);
  const bool linked = written && (link(name.c_str(), file.c_str()) == 0 || errno == EEXIST);
  const int why = errno;
  unlink(name.c_str());
  if (!linked) return Error{file.string() + ": cannot be written: " + std::strerror(why)};
  return {};
}

Result<void> make_demo_certificate(const fs::path& file, const std::string& listen) {
  CertificateOptions options{.name = "gnomon demo", .hosts = {"localhost", "127.0.0.1", "::1"}};
  if (std::find(options.hosts.begin(), options.hosts.end(), listen) == options.hosts.end()) {
    options.hosts.push_back(listen);
  }
  options.lasts = kLasts;
  const auto identity = make_certificate(options);
  if (!identity) return identity.error();
  return write_once(file, identity->key + identity->certificate, 0600);
}

Result<void> write_pin(const fs::path& certificate, const fs::path& file) {
  std::ostringstream pem;
  pem << std::ifstream(certificate).rdbuf();
  const auto pin = pin_of_pem(pem.str());
  if (!pin) return Error{certificate.string() + ": " + pin.error().message};
  std::ofstream out(file);
  out << protocol::to_string(*pin) << "\n";
  return {};
}

}  // namespace

fs::path state_folder(const ServerConfig& config) {
  if (!config.state_folder.empty()) return config.state_folder;
  if (const auto folder = environment("STATE_DIRECTORY"); !folder.empty())
    return folder.substr(0, folder.find(':'));
  if (const auto folder = environment("XDG_STATE_HOME"); !folder.empty()) return fs::path(folder) / "gnomon";
  return fs::path(environment("HOME")) / ".local/state/gnomon";
}

Result<TlsConfig> demo_certificate(const ServerConfig& config) {
  const fs::path folder = state_folder(config), file = folder / "demo.pem", pin = folder / "demo.pin";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{"server.state_folder: " + folder.string() + ": " + error.message()};
  if (!fs::exists(file)) {
    if (auto made = make_demo_certificate(file, config.listen); !made) return made.error();
  }
  if (auto written = write_pin(file, pin); !written) return written.error();
  return TlsConfig{file, file, config.tls.client_ca, config.tls.client_crl};
}

}  // namespace gnomon::daemon
