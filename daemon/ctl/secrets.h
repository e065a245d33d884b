// Makes the secrets that gnomond's configuration needs: certificates and tokens. Needs no running daemon.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::ctl {

struct CertsRequest {
  std::filesystem::path out;         // folder; created if it does not exist
  std::vector<std::string> hosts;    // names and addresses by which clients reach the server
  std::string fleet = {};            // whose name, and all names right below it, the server has too; if empty, none
  std::vector<std::string> tenants;  // each gets a client certificate
  uint32_t days = 365;
  bool renew = false;  // replaces existing certificates
};

// Makes an authority (unless the folder has one), a server's certificate and those of clients:
//
//   ca.pem      ca-key.pem        signs the others: keep its key away from the server
//   server.pem  server-key.pem    server.tls.certificate and .key
//   TENANT.pem  TENANT-key.pem    gnomon-client --certificate and --key
//
// Keys have mode 0600. Returns instructions for a person. On an error some of the files may have been replaced.
Result<std::string> make_certs(const CertsRequest& request);

// Makes a token. Returns it and its hash, which goes into the configuration, as text for a person.
std::string token_text();

}  // namespace gnomon::ctl
