// Demo mode's certificate: self-signed, made at the first start, kept in the state folder and used again.
//
//   demo.pem   0600  private key and certificate
//   demo.pin         the certificate's fingerprint, what clients pin (gnomon-client --pin FILE)
#pragma once

#include "common/result.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Error: the folder and why it is of no use. Several daemons may start in the same folder at once: they share one.
Result<TlsConfig> demo_certificate(const ServerConfig& config);

// The configured folder; else $STATE_DIRECTORY (which systemd sets), $XDG_STATE_HOME/gnomon or ~/.local/state/gnomon.
std::filesystem::path state_folder(const ServerConfig& config);

}  // namespace gnomon::daemon
