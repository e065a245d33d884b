// Determines who a client is: the tenant that its Hello names, if its token or its certificate is valid for it; and
// whether a session may go on that was opened so.
//
// A stranger does not learn which tenants there are: a wrong token and an unknown name get the same answer after the
// same work, and so do no token and an unknown name. The operator's counters and log distinguish them.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <variant>

#include "daemon/config/config.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/frame/credential.h"
#include "daemon/metrics/faults.h"
#include "daemon/security/client_certificates.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// The refusal that the client is sent, and the fault that is counted.
struct Rejected {
  protocol::Refused refused;
  Fault fault;
  std::string tenant;  // that the client named or left to us
};

struct Identified {
  TenantId tenant;
  Credential credential;  // `shown` is not set
};

// `certificate`: without names if the client showed none. A client that names no tenant belongs to that of its
// certificate, or else to the tenant `default`.
std::variant<Identified, Rejected> identify(const protocol::Hello& hello, const ClientCertificate& certificate,
                                            const TenantDirectory& directory, ServerMode mode);

// What decides whether a session may go on.
struct CredentialRules {
  const TenantDirectory& tenants;
  const ClientAuthorities& authorities;
  ServerMode mode;
  std::chrono::seconds max_age;  // since the client showed its credential; 0: no limit
};

// Why a session of this tenant that was opened with this credential may not go on, as its client is told; nullopt if it
// may: the tenant is served, the credential would be accepted again, and it is not too old.
std::optional<std::string> objection_to(const Credential& credential, TenantId tenant, const CredentialRules& rules,
                                        std::chrono::sys_seconds now);

// Error if nobody could connect as one of the tenants; its text names the remedies.
Result<void> check_tenants(const Config& config);

}  // namespace gnomon::daemon
