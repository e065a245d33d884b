// Who is an operator among the accounts of this machine.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "common/result.h"
#include "daemon/admin/http_message.h"

namespace gnomon::daemon {

// The number of a group; nullopt for an empty name. Error if there is none of this name; it names admin.group.
Result<std::optional<gid_t>> group_of(const std::string& name);

// Root, the account that we run as, and the members of `group`.
bool may_change(const PeerCredentials& process, std::optional<gid_t> group);

// "root(0)", as the audit log has it; "uid(1234)" if the account has no name.
std::string account_name(uid_t uid);

}  // namespace gnomon::daemon
