// The data channel's first secrets, from the TLS session of the control connection (RFC 8446, 7.5): both ends compute
// them, none crosses the wire.
#pragma once

#include "common/result.h"
#include "protocol/seal.h"

struct ssl_st;

namespace gnomon::protocol {

// `tls`: after its handshake. Error: the session is not TLS 1.3 or not established.
Result<SealSecrets> export_secrets(ssl_st* tls, SessionId session, CipherId cipher);

// What a client proves itself with that comes back on another connection: a secret of the connection on which the
// session was opened, and how it is shown on the other one, where nobody else can repeat it.
Result<Secret> export_resumption_secret(ssl_st* tls, SessionId session);
Result<Secret> resumption_proof(ssl_st* tls, SessionId session, const Secret& resumption_secret);

}  // namespace gnomon::protocol
