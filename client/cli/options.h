// Reads the values that the programs' command lines share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "client/net/path_watch.h"
#include "client/net/trust.h"
#include "common/result.h"

namespace gnomon::client {

struct Size {
  uint16_t width = 0;
  uint16_t height = 0;
};

// "1920x1080". Both from `least` to protocol::kMaxSide.
Result<Size> parse_size(std::string_view text, uint32_t least = 1);

// --pin, --ca, --certificate, --key and --fleet. `App` is CLI::App, which no library here includes.
template <class App>
void declare_trust(App& app, Trust& trust) {
  app.add_option("--pin", trust.pin,
                 "the server's certificate: its fingerprint, or a file with it in the first line")
      ->type_name("sha256:HEX|FILE");
  app.add_option("--ca", trust.authorities, "who may have signed the server's certificate; else the system's list")
      ->type_name("FILE");
  app.add_option("--certificate", trust.certificate, "this client's own, for servers that take it for a token")
      ->type_name("FILE");
  app.add_option("--key", trust.key, "its private key")->type_name("FILE");
  app.add_option("--fleet", trust.fleet,
                 "the fleet's name, where the server is its door; certificates are of that name")
      ->type_name("NAME");
}

// --transport. `App` as above.
template <class App>
void declare_transport(App& app, std::string& transport) {
  app.add_option("--transport", transport,
                 "udp, tcp (all of it over the control connection), or auto: udp while it passes")
      ->type_name("TRANSPORT");
}

// The file's first line. Error if the file cannot be read or that line is empty.
Result<std::string> read_token(const std::filesystem::path& file);

}  // namespace gnomon::client
