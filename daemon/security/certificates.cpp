#include "daemon/security/certificates.h"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <asio/ip/address.hpp>
#include <memory>

#include "daemon/security/freed_by.h"

namespace gnomon::daemon {
namespace {

using Certificate = std::unique_ptr<X509, FreedBy<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, FreedBy<EVP_PKEY_free>>;
using Bio = std::unique_ptr<BIO, FreedBy<BIO_free_all>>;

Error library_error(const std::string& what) {
  char text[256];
  ERR_error_string_n(ERR_get_error(), text, sizeof text);
  return Error{what + ": " + text};
}

Bio reading(const std::string& pem) { return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()))); }

std::string text_of(BIO* bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio, &bytes);
  return {bytes, static_cast<size_t>(size)};
}

bool extend(X509* certificate, X509* issuer, int id, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* const extension = X509V3_EXT_conf_nid(nullptr, &context, id, value.c_str());
  const bool done = extension && X509_add_ext(certificate, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return done;
}

// "DNS:edge.example,IP:10.0.0.7"
std::string alternative_names(const std::vector<std::string>& hosts) {
  std::string names;
  for (const std::string& host : hosts) {
    asio::error_code not_an_address;
    asio::ip::make_address(host, not_an_address);
    names.append(names.empty() ? "" : ",").append(not_an_address ? "DNS:" : "IP:").append(host);
  }
  return names;
}

bool describe(X509* certificate, X509* issuer, const CertificateOptions& options) {
  using Use = CertificateOptions::Use;
  const bool authority = options.use == Use::authority;
  const std::string names = alternative_names(options.hosts);
  return extend(certificate, issuer, NID_basic_constraints, authority ? "critical,CA:TRUE" : "critical,CA:FALSE") &&
         extend(certificate, issuer, NID_key_usage,
                authority ? "critical,keyCertSign,cRLSign" : "critical,digitalSignature") &&
         extend(certificate, issuer, NID_subject_key_identifier, "hash") &&
         (authority || extend(certificate, issuer, NID_ext_key_usage,
                              options.use == Use::server ? "serverAuth" : "clientAuth")) &&
         (names.empty() || extend(certificate, issuer, NID_subject_alt_name, names));
}

bool set_serial(X509* certificate) {
  uint8_t bytes[16];
  if (RAND_bytes(bytes, sizeof bytes) != 1) return false;
  bytes[0] &= 0x7f;  // positive
  BIGNUM* const number = BN_bin2bn(bytes, sizeof bytes, nullptr);
  const bool done = number && BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate));
  BN_free(number);
  return done;
}

bool fill(X509* certificate, X509* issuer, EVP_PKEY* key, const CertificateOptions& options) {
  X509_NAME* const subject = X509_get_subject_name(certificate);
  return X509_set_version(certificate, X509_VERSION_3) && set_serial(certificate) &&
         X509_gmtime_adj(X509_getm_notBefore(certificate), options.starts_in.count()) &&
         X509_gmtime_adj(X509_getm_notAfter(certificate), options.lasts.count()) &&
         X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(options.name.c_str()), -1, -1, 0) &&
         X509_set_issuer_name(certificate, X509_get_subject_name(issuer)) && X509_set_pubkey(certificate, key) &&
         describe(certificate, issuer, options);
}

}  // namespace

Result<Identity> make_certificate(const CertificateOptions& options, const Identity* issuer) {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate(X509_new());
  Certificate issuer_certificate;
  Key issuer_key;
  if (issuer) {
    issuer_certificate.reset(PEM_read_bio_X509(reading(issuer->certificate).get(), nullptr, nullptr, nullptr));
    issuer_key.reset(PEM_read_bio_PrivateKey(reading(issuer->key).get(), nullptr, nullptr, nullptr));
    if (!issuer_certificate || !issuer_key) return library_error("the issuer's certificate or key cannot be read");
  }
  X509* const signer = issuer ? issuer_certificate.get() : certificate.get();
  if (!key || !certificate || !fill(certificate.get(), signer, key.get(), options) ||
      X509_sign(certificate.get(), issuer ? issuer_key.get() : key.get(), EVP_sha256()) == 0) {
    return library_error("cannot make a certificate for '" + options.name + "'");
  }
  const Bio certificate_text(BIO_new(BIO_s_mem())), key_text(BIO_new(BIO_s_secmem()));
  if (!PEM_write_bio_X509(certificate_text.get(), certificate.get()) ||
      !PEM_write_bio_PKCS8PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr)) {
    return library_error("cannot write a certificate");
  }
  return Identity{text_of(certificate_text.get()), text_of(key_text.get())};
}

Result<protocol::Pin> pin_of_pem(const std::string& pem) {
  const Certificate certificate(PEM_read_bio_X509(reading(pem).get(), nullptr, nullptr, nullptr));
  if (!certificate) return library_error("no certificate in PEM");
  return protocol::pin_of(certificate.get());
}

}  // namespace gnomon::daemon
