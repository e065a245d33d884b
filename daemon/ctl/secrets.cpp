#include "daemon/ctl/secrets.h"

#include <sstream>

#include "daemon/ctl/new_file.h"
#include "daemon/security/certificates.h"
#include "daemon/security/tokens.h"

namespace gnomon::ctl {
namespace {

namespace fs = std::filesystem;
using daemon::CertificateOptions;
using daemon::Identity;
using Use = CertificateOptions::Use;

constexpr std::chrono::hours kDay{24};
constexpr auto kAuthorityLasts = 10 * 365 * kDay;

class Folder {
 public:
  explicit Folder(const CertsRequest& request) : request_(request) {}

  Result<void> open() {
    std::error_code error;
    fs::create_directories(request_.out, error);
    if (error) return Error{request_.out.string() + ": " + error.message()};
    for (const std::string& name : names()) {
      if (!request_.renew && fs::exists(certificate(name))) {
        return Error{certificate(name).string() + " is there already; --renew replaces it"};
      }
    }
    return {};
  }

  Result<void> fill() {
    if (auto done = open_authority(); !done) return done;
    std::vector<std::string> hosts = request_.hosts;
    if (!request_.fleet.empty()) hosts.insert(hosts.end(), {request_.fleet, "*." + request_.fleet});
    if (auto done = make("server", {.name = hosts.front(), .hosts = hosts}); !done) return done;
    for (const std::string& tenant : request_.tenants) {
      if (auto done = make(tenant, {.name = tenant, .hosts = {}, .use = Use::client}); !done) return done;
    }
    return {};
  }

  fs::path certificate(const std::string& name) const { return request_.out / (name + ".pem"); }
  fs::path key(const std::string& name) const { return request_.out / (name + "-key.pem"); }

 private:
  std::vector<std::string> names() const {
    std::vector<std::string> all = request_.tenants;
    all.insert(all.begin(), "server");
    return all;
  }

  Result<void> open_authority() {
    if (fs::exists(certificate("ca"))) {
      authority_ = {read_file(certificate("ca")), read_file(key("ca"))};
      return {};
    }
    CertificateOptions options{.name = "Gnomon authority", .hosts = {}, .use = Use::authority};
    options.lasts = kAuthorityLasts;
    auto made = daemon::make_certificate(options);
    if (!made) return made.error();
    authority_ = std::move(*made);
    return save("ca", authority_);
  }

  Result<void> make(const std::string& name, CertificateOptions options) {
    options.lasts = request_.days * kDay;
    const auto made = daemon::make_certificate(options, &authority_);
    if (!made) return made.error();
    return save(name, *made);
  }

  Result<void> save(const std::string& name, const Identity& identity) {
    if (auto done = write_file(key(name), identity.key, 0600); !done) return done;
    return write_file(certificate(name), identity.certificate, 0644);
  }

  const CertsRequest& request_;
  Identity authority_;
};

bool is_file_name(const std::string& name) {
  return !name.empty() && name != "ca" && name != "server" && name.find('/') == std::string::npos;
}

std::string advice(const CertsRequest& request, const Folder& folder) {
  std::ostringstream text;
  text << "server:\n  tls:\n    certificate: " << folder.certificate("server").string()
       << "\n    key: " << folder.key("server").string() << "\n";
  if (!request.tenants.empty()) text << "    client_ca: " << folder.certificate("ca").string() << "\n";
  text << "\nclients: --ca " << folder.certificate("ca").string() << "\n";
  for (const std::string& tenant : request.tenants) {
    text << "  of " << tenant << ": --certificate " << folder.certificate(tenant).string() << " --key "
         << folder.key(tenant).string() << "\n";
  }
  text << "Keep " << folder.key("ca").string() << " where the server is not: it makes certificates for anybody.\n";
  return text.str();
}

}  // namespace

Result<std::string> make_certs(const CertsRequest& request) {
  for (const std::string& tenant : request.tenants) {
    if (!is_file_name(tenant)) return Error{"'" + tenant + "' is no name for a client's certificate"};
  }
  Folder folder(request);
  if (auto opened = folder.open(); !opened) return opened.error();
  if (auto filled = folder.fill(); !filled) return filled.error();
  return advice(request, folder);
}

std::string token_text() {
  const std::string token = daemon::make_token();
  return "token         " + token + "\ntoken_sha256  " + daemon::to_hex(daemon::hash_of(token)) + "\n";
}

}  // namespace gnomon::ctl
