// How a client knows that it speaks to the right server, and what it shows of itself. TLS 1.3 alone.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/result.h"

namespace asio::ssl {
class context;
}

namespace gnomon::client {

struct Trust {
  // The one certificate to accept: "sha256:..." or a file that has this in its first line. Empty: what an authority
  // has signed for the server's name.
  std::string pin = {};
  std::filesystem::path authorities = {};  // PEM; empty: the system's
  // The client's own, where the server takes certificates for tokens; PEM, empty: none.
  std::filesystem::path certificate = {};
  std::filesystem::path key = {};
};

// The TLS context of one connection to `host`, a name or an address. Error: the file and why it is of no use.
Result<std::unique_ptr<asio::ssl::context>> open_trust(const Trust& trust, const std::string& host);

}  // namespace gnomon::client
