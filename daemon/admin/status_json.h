// The answer to `/status`, on which `gnomonctl status` and the operators' page are based.
#pragma once

#include <string>

#include "daemon/admin/operated_parts.h"

namespace gnomon::daemon {

// JSON in UTF-8, ending with a newline. Any thread; it waits for no other thread.
std::string status_json(const OperatedParts& parts);

}  // namespace gnomon::daemon
