// Percent-encoding of addresses (RFC 3986, 2.1). Pure.
#pragma once

#include <string>
#include <string_view>

namespace gnomon::daemon::web {

// What is no valid escape stays as it is.
std::string percent_decoded(std::string_view text);
// For a path, whose slashes stay.
std::string percent_encoded(std::string_view text);

}  // namespace gnomon::daemon::web
