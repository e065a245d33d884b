// How a client authenticates the server, and itself to the server. TLS 1.3 only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/result.h"

struct ssl_st;

namespace asio::ssl {
class context;
}

namespace gnomon::client {

struct Trust {
  // The one certificate to accept: "sha256:..." or a file that has this in its first line. Empty: any that an authority
  // has signed for the server's name or address.
  std::string pin = {};
  std::filesystem::path authorities = {};  // PEM file; if empty, the system's
  // The client's own, for servers that accept certificates instead of tokens. PEM files; if empty, none.
  std::filesystem::path certificate = {};
  std::filesystem::path key = {};
  // The name of the fleet whose door the server is: certificates are good for this name, wherever the client connects to.
  // Empty: the server is not known to be a door.
  std::string fleet = {};
};

// What a client that asks for `scene` says in TLS whom it wants (SNI), so that a fleet's door sends those of one scene to
// one server; of a single server its name. Empty: nothing.
std::string server_name(const Trust& trust, const std::string& host, const std::string& scene);

// The fingerprint of the certificate that the server has shown in this handshake, whether it was accepted or not; empty
// if it has shown none. Of handshakes in a context of open_trust().
std::string shown_pin(const ssl_st* tls);

// The TLS context of one connection to `host`, a name or an address, or to a fleet's server there. Error: the file and why it cannot be used.
Result<std::unique_ptr<asio::ssl::context>> open_trust(const Trust& trust, const std::string& host);

}  // namespace gnomon::client
