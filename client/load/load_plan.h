// The clients that take part in a load run.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace gnomon::client {

// Clients of one tenant.
struct LoadGroup {
  std::string tenant = {};      // if empty, the server's default
  std::string token_file = {};  // if empty, none
  std::string token = {};       // as read_tokens() has read it
  size_t clients = 0;
};

// NAME:TOKENFILE:CLIENTS, where TOKENFILE may be empty.
Result<LoadGroup> parse_group(std::string_view text);

// How many clients in how many runs: "8", or "1..64", which doubles from run to run and ends with the last.
Result<std::vector<size_t>> parse_clients(std::string_view text);

// Without groups: `clients` clients of the default tenant. With groups: these, whose sum must be `clients` (0: any sum
// is accepted).
Result<std::vector<LoadGroup>> plan_load(const std::vector<std::string>& groups, size_t clients);

Result<void> read_tokens(std::vector<LoadGroup>& plan);

}  // namespace gnomon::client
