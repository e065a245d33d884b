// By what a client was let in. A session remembers it, also when it is resumed or served by the next process, so that it
// ends when its credential is revoked or expires.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

namespace gnomon::daemon {

// Plain memory without secrets: it is part of records that another process of the same program reads.
struct Credential {
  enum class Kind : uint8_t { none, token, certificate };

  Kind kind = Kind::none;  // none: the tenant is open
  // Of a token its SHA-256; of a certificate the SHA-256 of its issuer's name and its serial number, which together are
  // unique (RFC 5280, 4.1.2.2) and what revocation lists name.
  std::array<uint8_t, 32> id{};
  // Of a certificate: the SHA-256 of the name and public key of the authority that it leads to (RFC 5280, 6.1.1).
  std::array<uint8_t, 32> authority{};
  std::chrono::sys_seconds expires =
      std::chrono::sys_seconds::max();  // the first certificate of the chain that does
  std::chrono::sys_seconds shown{};     // when the client showed it

  friend bool operator==(const Credential&, const Credential&) = default;
};

}  // namespace gnomon::daemon
