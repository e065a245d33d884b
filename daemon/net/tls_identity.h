// The server's certificate where browsers know it: one that an authority of this machine's own trust store has signed.
#pragma once

#include <asio/ssl/context.hpp>

#include <optional>

#include "daemon/security/certificates.h"

namespace gnomon::daemon {

// The certificate of a complete context, with its chain and key; nullopt if it is self-made, or of an authority that
// this machine does not trust: browsers would not trust it for QUIC either.
std::optional<Identity> trusted_identity(asio::ssl::context& context);

}  // namespace gnomon::daemon
