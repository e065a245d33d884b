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
  std::vector<std::string> tenants = {};  // each gets a token; if empty, `default`
  std::vector<std::string> scenes = {};   // NAME of a built-in one, NAME=FILE or FILE; if empty, the built-in ones
  std::string listen = {};                // address of the clients' ports; if empty, 0.0.0.0
  uint16_t port = 0;                      // of clients; 0: 7600
  uint32_t days = 365;                    // how long the server's certificate lasts
  std::optional<bool> browsers = {};      // whether they are served too (`web.listen`); unsaid: they are not
  std::filesystem::path systemd =
      {};  // for the socket's drop-in; if empty, the system's for /etc/gnomon, else below `out`
  // Of a node of a fleet; else empty. Such a node needs the next two.
  std::string fleet = {};                 // its name
  std::string public_address = {};        // where this node's clients send their datagrams
  std::vector<std::string> proxies = {};  // addresses of the doors
  std::string door_listen = {};           // which address doors ask; if empty, the public one
  uint16_t door_port = 0;                 // 0: as it was, or the usual one
};

bool is_built_in(const std::string& scene);

// What the request leaves open is taken from the configuration in its folder, if init() has written that. Error: it cannot
// be read.
Result<void> take_from_before(InitRequest& request);

// Asks on `out` for what the request lacks and reads the answers from `in`; an empty answer takes what is proposed.
void ask_for_missing(InitRequest& request, std::istream& in, std::ostream& out);

// Error: something is missing, or is none of what is allowed there.
Result<void> check_init(const InitRequest& request);

// Writes
//
//   gnomond.yaml                               the configuration; one that is there becomes gnomond.yaml.before, and if
//                                              init() has written it, its further keys stay
//   credentials/  server.pem server-key.pem TENANT.sha256    for the daemon
//   private/      ca.pem ca-key.pem                          the authority; one that is there is kept and signs
//   private/clients/TENANT/  ca.pem token                    to be handed over; a token that is there is kept
//   SYSTEMD/gnomond.socket.d/gnomon.conf                     the addresses that systemd opens
//
// and returns the next steps for a person. On an error some of the files may have been written.
Result<std::string> init(const InitRequest& request);

}  // namespace gnomon::ctl
