#include "daemon/security/digests.h"

#include <openssl/evp.h>

#include <cstdlib>

namespace gnomon::daemon {
namespace {

template <size_t kSize>
std::array<uint8_t, kSize> digest(std::span<const uint8_t> bytes, const EVP_MD* how) {
  std::array<uint8_t, kSize> out{};
  if (EVP_Digest(bytes.data(), bytes.size(), out.data(), nullptr, how, nullptr) != 1) std::abort();
  return out;
}

}  // namespace

std::array<uint8_t, 32> sha256(std::span<const uint8_t> bytes) { return digest<32>(bytes, EVP_sha256()); }

std::array<uint8_t, 20> sha1(std::span<const uint8_t> bytes) { return digest<20>(bytes, EVP_sha1()); }

std::string base64(std::span<const uint8_t> bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  out.resize(static_cast<size_t>(
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()), bytes.data(), static_cast<int>(bytes.size()))));
  return out;
}

}  // namespace gnomon::daemon
