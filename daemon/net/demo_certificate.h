// Demo mode's certificate: self-signed, made at the first start, kept in the state folder and reused.
//
//   demo.pem   0600  private key and certificate
//   demo.pin         the certificate's fingerprint, which clients pin (gnomon-client --pin FILE)
#pragma once

#include "common/result.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Makes the certificate if there is none. The error names the folder or file and the reason. Several daemons may start
// with the same folder at once: they share one certificate.
Result<TlsConfig> demo_certificate(const ServerConfig& config);

// The configured folder; else $STATE_DIRECTORY (which systemd sets), $XDG_STATE_HOME/gnomon or ~/.local/state/gnomon.
std::filesystem::path state_folder(const ServerConfig& config);

}  // namespace gnomon::daemon
