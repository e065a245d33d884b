// Why a daemon serves no new clients, for `/readyz`, `/status` and those who ask there. Any thread.
#pragma once

#include <string>

#include "daemon/admin/operated_parts.h"

namespace gnomon::daemon {

// "scenes are being loaded: temple (43%)"; several with "; " between them. Empty: it is ready.
std::string why_not_ready(const OperatedParts& parts);

}  // namespace gnomon::daemon
