// Makes certificates: gnomond's own in demo mode, those of a site with `gnomonctl make-certs`, and those of tests.
//
// Keys are EC P-256, certificates X.509 v3 signed with SHA-256, which every TLS 1.3 client accepts.
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
  std::vector<std::string> hosts;  // DNS names and addresses of the subject
  Use use = Use::server;
  std::chrono::seconds starts_in{-3600};  // from now; in the past, as clocks differ
  std::chrono::seconds lasts{0};          // from now
};

// Makes a new key and its certificate, signed by `issuer`, or by itself if that is nullptr.
Result<Identity> make_certificate(const CertificateOptions& options, const Identity* issuer = nullptr);

// The pin of the first certificate in a PEM text.
Result<protocol::Pin> pin_of_pem(const std::string& pem);

}  // namespace gnomon::daemon
