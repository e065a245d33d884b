// Determines who a client is: the tenant that its Hello names, if its token or its certificate is valid for it.
//
// A stranger does not learn which tenants there are: a wrong token and an unknown name get the same answer after the
// same work. The operator's counters distinguish the two.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/metrics/faults.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// The refusal that the client is sent, and the fault that is counted.
struct Rejected {
  protocol::Refused refused;
  Fault fault;
};

// `certificate_names`: the names in a client certificate that one of our authorities has signed, empty if the client
// showed none. A client that names no tenant belongs to that of its certificate, or else to the tenant `default`.
std::variant<TenantId, Rejected> identify(const protocol::Hello& hello,
                                          const std::vector<std::string>& certificate_names,
                                          const TenantDirectory& directory, ServerMode mode);

// Error if nobody could connect as one of the tenants; its text names the remedies.
Result<void> check_tenants(const Config& config);

}  // namespace gnomon::daemon
