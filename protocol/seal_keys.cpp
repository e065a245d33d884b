#include "protocol/seal_keys.h"

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/kdf.h>

#if defined(__aarch64__)
#include <asm/hwcap.h>
#include <sys/auxv.h>
#endif

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace gnomon::protocol {
namespace {

// For calls that fail only if OpenSSL is broken or memory is exhausted. Aborts: continuing could send plaintext.
void must(int done) {
  if (done <= 0) std::abort();
}

// HKDF-Expand with SHA-256 (RFC 5869, 2.3).
void expand(const Secret& secret, std::string_view label, std::span<uint8_t> out) {
  EVP_KDF* const kdf = EVP_KDF_fetch(nullptr, OSSL_KDF_NAME_HKDF, nullptr);
  EVP_KDF_CTX* const context = EVP_KDF_CTX_new(kdf);
  int mode = EVP_KDF_HKDF_MODE_EXPAND_ONLY;
  std::string digest = "SHA256";
  const OSSL_PARAM parameters[] = {
      OSSL_PARAM_construct_int(OSSL_KDF_PARAM_MODE, &mode),
      OSSL_PARAM_construct_utf8_string(OSSL_KDF_PARAM_DIGEST, digest.data(), digest.size()),
      OSSL_PARAM_construct_octet_string(OSSL_KDF_PARAM_KEY, const_cast<uint8_t*>(secret.data()), secret.size()),
      OSSL_PARAM_construct_octet_string(OSSL_KDF_PARAM_INFO, const_cast<char*>(label.data()), label.size()),
      OSSL_PARAM_construct_end()};
  must(EVP_KDF_derive(context, out.data(), out.size(), parameters));
  EVP_KDF_CTX_free(context);
  EVP_KDF_free(kdf);
}

const EVP_CIPHER* algorithm(CipherId cipher) {
  return cipher == CipherId::chacha20_poly1305 ? EVP_chacha20_poly1305() : EVP_aes_128_gcm();
}

int size_of(std::span<const uint8_t> bytes) { return static_cast<int>(bytes.size()); }

}  // namespace

void Aead::Free::operator()(evp_cipher_ctx_st* context) const { EVP_CIPHER_CTX_free(context); }

AeadKey::AeadKey(CipherId cipher, const Secret& secret) : size(cipher == CipherId::chacha20_poly1305 ? 32 : 16) {
  expand(secret, "gnomon 2 key", std::span(bytes).first(size));
  expand(secret, "gnomon 2 iv", iv);
}

bool is_equal(const Secret& a, const Secret& b) { return CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0; }

void wipe(void* memory, size_t bytes) { OPENSSL_cleanse(memory, bytes); }

AeadKey::~AeadKey() { wipe(bytes.data(), bytes.size()); }

Aead::Aead(CipherId cipher, const Secret& secret, bool sealing) : context_(EVP_CIPHER_CTX_new()) {
  const AeadKey made(cipher, secret);
  iv_ = made.iv;
  must(EVP_CipherInit_ex(context_.get(), algorithm(cipher), nullptr, made.bytes.data(), iv_.data(),
                         sealing ? 1 : 0));
}

AeadKey::Nonce Aead::nonce(uint64_t sequence) const {
  AeadKey::Nonce made = iv_;
  for (size_t i = 0; i < 8; ++i) made[4 + i] ^= static_cast<uint8_t>(sequence >> (8 * i));
  return made;
}

void Aead::seal(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> text, uint8_t* out) {
  EVP_CIPHER_CTX* const context = context_.get();
  int written = 0;
  must(EVP_EncryptInit_ex(context, nullptr, nullptr, nullptr, nonce(sequence).data()));
  must(EVP_EncryptUpdate(context, nullptr, &written, header.data(), size_of(header)));
  if (!text.empty()) must(EVP_EncryptUpdate(context, out, &written, text.data(), size_of(text)));
  must(EVP_EncryptFinal_ex(context, out + text.size(), &written));
  must(EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, kTagBytes, out + text.size()));
}

bool Aead::open(uint64_t sequence, std::span<const uint8_t> header, std::span<const uint8_t> sealed, uint8_t* out) {
  EVP_CIPHER_CTX* const context = context_.get();
  const auto text = sealed.first(sealed.size() - kTagBytes);
  std::array<uint8_t, kTagBytes> tag;
  std::memcpy(tag.data(), sealed.data() + text.size(), tag.size());
  int written = 0;
  must(EVP_DecryptInit_ex(context, nullptr, nullptr, nullptr, nonce(sequence).data()));
  must(EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, kTagBytes, tag.data()));
  must(EVP_DecryptUpdate(context, nullptr, &written, header.data(), size_of(header)));
  if (!text.empty()) must(EVP_DecryptUpdate(context, out, &written, text.data(), size_of(text)));
  uint8_t nothing = 0;
  return EVP_DecryptFinal_ex(context, &nothing, &written) > 0;
}

Secret next_secret(const Secret& secret) {
  Secret next;
  expand(secret, "gnomon 2 next", next);
  return next;
}

void EpochSecret::go_on(const Secret& next) {
  by_parity[(epoch + 1) % 2] = next;
  std::atomic_signal_fence(std::memory_order_seq_cst);  // orders the stores for the compiler; a kill needs no more
  ++epoch;
  std::atomic_signal_fence(std::memory_order_seq_cst);
  wipe(by_parity[(epoch + 1) % 2].data(), sizeof(Secret));
}

SealKeys::SealKeys(CipherId cipher, EpochSecret& at, bool sealing)
    : cipher_(cipher), sealing_(sealing), newest_(at), after_(next_secret(at.secret())) {
  by_epoch_[at.epoch % 3] = std::make_unique<Aead>(cipher, at.secret(), sealing);
}

SealKeys::~SealKeys() { wipe(after_.data(), after_.size()); }

Aead* SealKeys::of(uint64_t epoch) {
  if (epoch > newest_.epoch + 1 || epoch + 1 < newest_.epoch) return nullptr;
  auto& aead = by_epoch_[epoch % 3];
  if (epoch == newest_.epoch + 1 && !aead) aead = std::make_unique<Aead>(cipher_, after_, sealing_);
  return aead.get();
}

void SealKeys::begin(uint64_t epoch) {
  if (epoch != newest_.epoch + 1) return;
  newest_.go_on(after_);
  after_ = next_secret(after_);
  by_epoch_[(epoch + 1) % 3].reset();  // of two epochs ago
}

bool has_aes_instructions() {
#if defined(__x86_64__) || defined(__i386__)
  return __builtin_cpu_supports("aes") && __builtin_cpu_supports("pclmul");
#elif defined(__aarch64__)
  return (getauxval(AT_HWCAP) & HWCAP_AES) != 0;
#else
  return false;
#endif
}

}  // namespace gnomon::protocol
