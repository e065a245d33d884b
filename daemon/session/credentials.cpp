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

// What does not prove who the client is, by what it has shown and not by what there is to be shown here.
const char* unproven(const protocol::Hello& hello, const Names& certificate) {
  if (!hello.token.empty()) return "the token is not that of this tenant";
  if (!certificate.empty()) return "no token was sent, and the certificate is not of this tenant";
  return "no token was sent, and no certificate: this tenant's clients show one of them";
}

Rejected reject(RefusalCode code, Fault fault, const std::string& tenant, const char* unproven) {
  const char* const why = code == RefusalCode::bad_token ? unproven : "there is no such tenant here";
  return {refusal(code, why), fault, tenant};
}

}  // namespace

std::variant<Identified, Rejected> identify(const protocol::Hello& hello, const ClientCertificate& certificate,
                                            const TenantDirectory& directory, ServerMode mode) {
  const std::string name = wanted_tenant(hello, certificate.names, directory);
  const auto id = directory.find(name);
  // A tenant that does not exist is checked against a hash that no known token has, for the same amount of work.
  TenantConfig tenant;
  tenant.token_sha256 = {TokenHash{}};
  if (id) tenant = directory.config(*id);
  const TokenHash token = hash_of(hello.token);
  const bool token_is_good = is_among(token, tenant.token_sha256);
  if (!id) {
    const auto code =
        may_know(certificate.names, directory, mode) ? RefusalCode::unknown_tenant : RefusalCode::bad_token;
    return reject(code, Fault::refused_unknown_tenant, name, unproven(hello, certificate.names));
  }
  if (token_is_good) return Identified{*id, {.kind = Credential::Kind::token, .id = token}};
  if (contains(certificate.names, name)) {
    return Identified{*id,
                      {.kind = Credential::Kind::certificate,
                       .id = certificate.id,
                       .authority = certificate.authority,
                       .expires = certificate.expires}};
  }
  if (lets_anybody_in(tenant, mode)) return Identified{*id, {}};
  return reject(RefusalCode::bad_token, Fault::refused_bad_token, name, unproven(hello, certificate.names));
}

std::optional<std::string> objection_to(const Credential& credential, TenantId id, const CredentialRules& rules,
                                        std::chrono::sys_seconds now) {
  if (!rules.tenants.open(id)) return "the tenant is no longer served";
  const TenantConfig& tenant = rules.tenants.config(id);
  switch (credential.kind) {
    case Credential::Kind::none:
      if (!lets_anybody_in(tenant, rules.mode)) return "the tenant is no longer open to everybody";
      break;
    case Credential::Kind::token:
      if (!is_among(credential.id, tenant.token_sha256)) return "its token was revoked";
      break;
    case Credential::Kind::certificate:
      if (rules.authorities.revoked.contains(credential.id)) return "its certificate was revoked";
      if (!rules.authorities.trusted.contains(credential.authority)) {
        return "the authority of its certificate is no longer trusted";
      }
      if (credential.expires <= now) return "its certificate has expired";
      break;
  }
  if (rules.max_age.count() > 0 && now - credential.shown >= rules.max_age) {
    return "it is older than " + std::to_string(rules.max_age.count()) + " s: authenticate anew";
  }
  return std::nullopt;
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
