#include "daemon/config/token_files.h"

#include <sstream>

#include "daemon/security/readable_file.h"

namespace gnomon::daemon {
namespace {

constexpr size_t kMostHashes = 1024;

Result<std::vector<TokenHash>> read_hashes(const std::filesystem::path& file) {
  const auto text = read_file(file);
  if (!text) return text.error();
  std::istringstream stream(*text);
  std::vector<TokenHash> hashes;
  size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.empty()) continue;
    const auto hash = parse_token_hash(line);
    if (line.starts_with(kTokenMark)) {
      return Error{file.string() + ":" + std::to_string(number) +
                   ": is a token; here belongs its SHA-256, which gnomonctl make-token prints below it"};
    }
    if (!hash || hashes.size() == kMostHashes) {
      return Error{file.string() + ":" + std::to_string(number) +
                   ": allowed: at most 1024 hashes of tokens, 64 hexadecimal digits on a line each; gnomonctl "
                   "make-token makes some"};
    }
    hashes.push_back(*hash);
  }
  return hashes;
}

}  // namespace

std::vector<Error> read_token_files(Config& config) {
  std::vector<Error> errors;
  for (TenantConfig& tenant : config.tenants) {
    if (tenant.token_sha256_file.empty()) continue;
    const auto hashes = read_hashes(tenant.token_sha256_file);
    if (!hashes) {
      const std::string key = "tenants." + tenant.name + ".token_sha256_file: ";
      errors.push_back(placed(config, Error{key + hashes.error().message}));
      continue;
    }
    tenant.token_sha256.insert(tenant.token_sha256.end(), hashes->begin(), hashes->end());
    std::string& told = config.values["tenants." + tenant.name + ".token_sha256"];
    for (const TokenHash& hash : *hashes) told += to_hex(hash) + "\n";
  }
  return errors;
}

}  // namespace gnomon::daemon
