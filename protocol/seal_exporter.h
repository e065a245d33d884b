// Derives the data channel's first secrets from the TLS session of the control connection with its exporter (RFC 8446,
// 7.5). Both ends compute them; none crosses the wire.
#pragma once

#include "common/result.h"
#include "protocol/seal.h"

struct ssl_st;

namespace gnomon::protocol {

// `tls` has completed its handshake. Error if the session is not TLS 1.3 or not established.
Result<SealSecrets> export_secrets(ssl_st* tls, SessionId session, CipherId cipher);

// For a client that resumes its session on another connection. The resumption secret is exported from the connection on
// which the session was opened; the proof shows on the other connection that the client knows it, and is valid there
// only. WIRE.md, "Resuming", is the specification. Errors as above.
Result<Secret> export_resumption_secret(ssl_st* tls, SessionId session);
Result<Secret> resumption_proof(ssl_st* tls, SessionId session, const Secret& resumption_secret);

}  // namespace gnomon::protocol
