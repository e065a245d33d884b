// A view of the viewer as a QR code, for the phone beside the screen:
//
//   /qr/FRAGMENT.svg   the address of this server's page with that fragment
//
// Pure. The symbol is libqrencode's.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "daemon/web/web_response.h"

namespace gnomon::daemon::web {

// The fragment, decoded; nullopt if the target is none of these.
std::optional<std::string> qr_target(std::string_view target);

// 400 if the address is too long for a code that a phone reads.
Response qr_page(const Request& request, const std::string& fragment);

}  // namespace gnomon::daemon::web
