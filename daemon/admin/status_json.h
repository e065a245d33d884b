// What `/status` answers, and with it `gnomonctl status` and the operators' page.
#pragma once

#include <string>

#include "daemon/admin/operated_parts.h"

namespace gnomon::daemon {

// JSON in UTF-8 with a line end. Any thread; it waits for no other.
std::string status_json(const OperatedParts& parts);

}  // namespace gnomon::daemon
