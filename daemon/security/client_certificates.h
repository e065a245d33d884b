// What the daemon reads of clients' certificates and of the authorities that it accepts them from. Any thread.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

struct ssl_st;
struct x509_st;
struct x509_store_st;

namespace gnomon::daemon {

using CertificateHash = std::array<uint8_t, 32>;

// A certificate that one of our authorities has signed. The default: the client showed none.
struct ClientCertificate {
  std::vector<std::string> names;  // common names and DNS names
  CertificateHash id{};            // of its issuer's name and serial number
  CertificateHash authority{};     // of the name and public key of the authority that its chain ends in
  std::chrono::sys_seconds expires = std::chrono::sys_seconds::max();  // the first of its chain that does
};

// The client's certificate. Precondition: the TLS handshake is done.
ClientCertificate certificate_of(ssl_st* tls);

// The authorities and revocation lists of a trust store, in the terms of ClientCertificate.
struct ClientAuthorities {
  std::set<CertificateHash> trusted;
  std::set<CertificateHash> revoked;
  std::chrono::sys_seconds expires = std::chrono::sys_seconds::max();  // the first authority that does
};
ClientAuthorities authorities_in(x509_store_st* store);

std::chrono::sys_seconds begin_of(const x509_st* certificate);  // its notBefore
std::chrono::sys_seconds end_of(const x509_st* certificate);    // its notAfter

}  // namespace gnomon::daemon
