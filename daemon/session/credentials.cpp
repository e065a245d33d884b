#include "daemon/session/credentials.h"

#include <algorithm>
#include <array>

#include "daemon/session/handshake.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using Names = std::vector<std::string>;

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool lets_anybody_in(const TenantConfig& tenant, ServerMode mode) {
  return tenant.open || (mode == ServerMode::demo && tenant.token_sha256.empty());
}

std::string wanted_tenant(const protocol::Hello& hello, const Names& certificate,
                          const TenantDirectory& directory) {
  if (!hello.tenant.empty()) return hello.tenant;
  const auto own = std::find_if(certificate.begin(), certificate.end(),
                                [&](const std::string& name) { return directory.find(name).has_value(); });
  return own == certificate.end() ? kDefaultTenant : *own;
}

// Whether the client may learn that there is no such tenant: it has a certificate, or every tenant is open, so that
// names are no secret.
bool may_know(const Names& certificate, const TenantDirectory& directory, ServerMode mode) {
  if (!certificate.empty()) return true;
  const auto all = directory.configs();
  return std::all_of(all.begin(), all.end(), [&](const auto& tenant) { return lets_anybody_in(tenant, mode); });
}

Rejected reject(RefusalCode code, Fault fault) {
  return {refusal(code, code == RefusalCode::bad_token ? "the token is not that of this tenant"
                                                       : "there is no such tenant here"),
          fault};
}

}  // namespace

std::variant<TenantId, Rejected> identify(const protocol::Hello& hello, const Names& certificate_names,
                                          const TenantDirectory& directory, ServerMode mode) {
  const std::string name = wanted_tenant(hello, certificate_names, directory);
  const auto id = directory.find(name);
  // A tenant that does not exist is checked against a hash that no known token has, for the same amount of work.
  TenantConfig tenant;
  tenant.token_sha256 = {TokenHash{}};
  if (id) tenant = directory.config(*id);
  const bool token_is_good = is_among(hash_of(hello.token), tenant.token_sha256);
  if (!id) {
    const auto code =
        may_know(certificate_names, directory, mode) ? RefusalCode::unknown_tenant : RefusalCode::bad_token;
    return reject(code, Fault::refused_unknown_tenant);
  }
  if (token_is_good || contains(certificate_names, name) || lets_anybody_in(tenant, mode)) return *id;
  return reject(RefusalCode::bad_token, Fault::refused_bad_token);
}

Result<void> check_tenants(const Config& config) {
  const bool by_certificate = !config.server.tls.client_ca.empty();
  for (const TenantConfig& tenant : config.tenants) {
    if (!tenant.token_sha256.empty() || by_certificate || lets_anybody_in(tenant, config.server.mode)) continue;
    return Error{
        std::string("tenants: nobody could connect as ") + tenant.name +
        ": it has no token_sha256. Make a token with\n  gnomonctl make-token\nand give its hash here; or set "
        "server.tls.client_ca, for clients with certificates; or open: true, to let anybody in"};
  }
  return {};
}

}  // namespace gnomon::daemon
