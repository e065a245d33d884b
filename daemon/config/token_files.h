// Tenants' tokens whose hashes stand in a file of their own: one that a first start makes, which leaves the
// configuration as it was shipped.
#pragma once

#include <vector>

#include "common/result.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Appends the hashes of each tenant's token_sha256_file to its token_sha256; paths are absolute (find_files). Errors
// name the key, the file and the line, one for each file. Blocking; the main thread, at the start and at each reload.
std::vector<Error> read_token_files(Config& config);

}  // namespace gnomon::daemon
