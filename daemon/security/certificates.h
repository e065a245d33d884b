// Makes certificates: gnomond's own in demo mode, a site's with `gnomonctl make-certs`, tests' own.
//
// Keys are EC P-256, certificates X.509 v3 signed with SHA-256: what every TLS 1.3 client takes.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/result.h"
#include "protocol/pin.h"

namespace gnomon::daemon {

// PEM. The key is a secret.
struct Identity {
  std::string certificate;
  std::string key;
};

struct CertificateOptions {
  enum class Use { server, client, authority };

  std::string name;                // the subject's common name
  std::vector<std::string> hosts;  // DNS names and addresses that it is for
  Use use = Use::server;
  std::chrono::seconds starts_in{-3600};  // clocks differ
  std::chrono::seconds lasts{0};          // from now
};

// A new key and its certificate, signed by `issuer`; null: by itself.
Result<Identity> make_certificate(const CertificateOptions& options, const Identity* issuer = nullptr);

// Of the first certificate in a PEM text.
Result<protocol::Pin> pin_of_pem(const std::string& pem);

}  // namespace gnomon::daemon
