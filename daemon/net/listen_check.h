// Whether the daemon could listen where its configuration says, without listening there.
#pragma once

#include <vector>

#include "common/result.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// An error for each address that is none of this machine's, and for each port that this process may not have. Ports that
// are in use are none: the daemon that is asked to reload has them itself.
std::vector<Error> check_listening(const Config& config);

}  // namespace gnomon::daemon
