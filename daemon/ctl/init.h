// `gnomonctl init`: all that production needs, from a few answers. Needs no running daemon.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::ctl {

struct InitRequest {
  std::filesystem::path out = "/etc/gnomon";
  std::vector<std::string> hosts = {};    // names and addresses by which clients reach the node
  std::vector<std::string> tenants = {};  // each gets a token; empty: `default`
  std::vector<std::string> scenes = {};   // NAME of a built-in one, NAME=FILE or FILE; empty: the built-in ones
  std::string listen = "0.0.0.0";         // address of the clients' ports
  uint16_t port = 7600;
  uint32_t days = 365;                // how long the server's certificate lasts
  std::optional<bool> browsers = {};  // whether they are served too (`web.listen`); unsaid: they are not
  std::filesystem::path systemd =
      {};  // for the socket's drop-in; empty: the system's for /etc/gnomon, else below `out`
};

// Asks on `out` for what the request lacks and reads the answers from `in`; an empty answer takes what is proposed.
void ask_for_missing(InitRequest& request, std::istream& in, std::ostream& out);

// Writes
//
//   gnomond.yaml                               the configuration; one that is there becomes gnomond.yaml.before
//   credentials/  server.pem server-key.pem TENANT.sha256    for the daemon
//   private/      ca.pem ca-key.pem                          the authority; one that is there is kept and signs
//   private/clients/TENANT/  ca.pem token                    to be handed over; a token that is there is kept
//   SYSTEMD/gnomond.socket.d/gnomon.conf                     the addresses that systemd opens
//
// and returns the next steps for a person. On an error some of the files may have been written.
Result<std::string> init(const InitRequest& request);

}  // namespace gnomon::ctl
