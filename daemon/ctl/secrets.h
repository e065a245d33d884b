// What gnomond's configuration needs of secrets: certificates and tokens. Needs no running daemon.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::ctl {

struct CertsRequest {
  std::filesystem::path out;         // folder; made if it is not there
  std::vector<std::string> hosts;    // names and addresses by which clients reach the server
  std::vector<std::string> tenants;  // for each, a client certificate
  uint32_t days = 365;
  bool renew = false;  // replaces certificates that are there already
};

// Makes an authority (unless its folder has one), a server's certificate and those of clients:
//
//   ca.pem      ca-key.pem        signs the others: keep its key away from the server
//   server.pem  server-key.pem    server.tls.certificate and .key
//   TENANT.pem  TENANT-key.pem    gnomon-client --certificate and --key
//
// Keys have mode 0600. Gives what to do with them, for a person. Error: nothing was replaced.
Result<std::string> make_certs(const CertsRequest& request);

// A token and the hash of it that the configuration has, for a person.
std::string token_text();

}  // namespace gnomon::ctl
