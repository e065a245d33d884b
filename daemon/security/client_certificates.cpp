#include "daemon/security/client_certificates.h"

#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

namespace gnomon::daemon {
namespace {

using Bytes = std::vector<unsigned char>;

std::string text_of(const ASN1_STRING* string) {
  unsigned char* utf8 = nullptr;
  const int size = ASN1_STRING_to_UTF8(&utf8, string);
  if (size < 0) return {};
  const std::string text(reinterpret_cast<char*>(utf8), static_cast<size_t>(size));
  OPENSSL_free(utf8);
  return text;
}

void add_common_names(X509* certificate, std::vector<std::string>& names) {
  const X509_NAME* const subject = X509_get_subject_name(certificate);
  for (int at = -1; (at = X509_NAME_get_index_by_NID(subject, NID_commonName, at)) >= 0;) {
    names.push_back(text_of(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at))));
  }
}

void add_dns_names(X509* certificate, std::vector<std::string>& names) {
  auto* const others =
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  for (int i = 0; i < sk_GENERAL_NAME_num(others); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(others, i);
    if (name->type == GEN_DNS) names.push_back(text_of(name->d.dNSName));
  }
  GENERAL_NAMES_free(others);
}

void append(Bytes& bytes, const X509_NAME* name) {
  const unsigned char* der = nullptr;
  size_t size = 0;
  if (X509_NAME_get0_der(name, &der, &size) == 1) bytes.insert(bytes.end(), der, der + size);
}

CertificateHash hash_of(const Bytes& bytes) {
  CertificateHash hash{};
  if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), nullptr, EVP_sha256(), nullptr) != 1) std::abort();
  return hash;
}

CertificateHash hash_of(const X509_NAME* issuer, const ASN1_INTEGER* serial) {
  Bytes bytes;
  append(bytes, issuer);
  const unsigned char* const digits = ASN1_STRING_get0_data(serial);
  bytes.insert(bytes.end(), digits, digits + ASN1_STRING_length(serial));
  return hash_of(bytes);
}

CertificateHash hash_of_authority(const X509* certificate) {
  Bytes bytes;
  append(bytes, X509_get_subject_name(certificate));
  unsigned char* der = nullptr;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(certificate), &der);
  if (size > 0) bytes.insert(bytes.end(), der, der + size);
  OPENSSL_free(der);
  return hash_of(bytes);
}

void add_revoked(X509_CRL* list, std::set<CertificateHash>& revoked) {
  STACK_OF(X509_REVOKED)* const entries = X509_CRL_get_REVOKED(list);
  for (int i = 0; i < sk_X509_REVOKED_num(entries); ++i) {
    const X509_REVOKED* const entry = sk_X509_REVOKED_value(entries, i);
    revoked.insert(hash_of(X509_CRL_get_issuer(list), X509_REVOKED_get0_serialNumber(entry)));
  }
}

std::chrono::sys_seconds at(const ASN1_TIME* time, std::chrono::sys_seconds otherwise) {
  std::tm calendar{};
  if (ASN1_TIME_to_tm(time, &calendar) != 1) return otherwise;
  return std::chrono::sys_seconds(std::chrono::seconds(timegm(&calendar)));
}

}  // namespace

std::chrono::sys_seconds begin_of(const X509* certificate) {
  return at(X509_get0_notBefore(certificate), std::chrono::sys_seconds::min());
}

std::chrono::sys_seconds end_of(const X509* certificate) {
  return at(X509_get0_notAfter(certificate), std::chrono::sys_seconds::max());
}

ClientCertificate certificate_of(SSL* tls) {
  ClientCertificate shown;
  X509* const certificate = SSL_get0_peer_certificate(tls);
  const STACK_OF(X509)* const chain = SSL_get0_verified_chain(tls);
  if (!certificate || SSL_get_verify_result(tls) != X509_V_OK || sk_X509_num(chain) < 1) return shown;
  add_common_names(certificate, shown.names);
  add_dns_names(certificate, shown.names);
  shown.id = hash_of(X509_get_issuer_name(certificate), X509_get0_serialNumber(certificate));
  shown.authority = hash_of_authority(sk_X509_value(chain, sk_X509_num(chain) - 1));
  for (int i = 0; i < sk_X509_num(chain); ++i)
    shown.expires = std::min(shown.expires, end_of(sk_X509_value(chain, i)));
  return shown;
}

ClientAuthorities authorities_in(X509_STORE* store) {
  ClientAuthorities found;
  const STACK_OF(X509_OBJECT)* const objects = X509_STORE_get0_objects(store);
  for (int i = 0; i < sk_X509_OBJECT_num(objects); ++i) {
    const X509_OBJECT* const object = sk_X509_OBJECT_value(objects, i);
    if (const X509* const certificate = X509_OBJECT_get0_X509(object)) {
      found.trusted.insert(hash_of_authority(certificate));
      found.expires = std::min(found.expires, end_of(certificate));
    } else if (X509_CRL* const list = X509_OBJECT_get0_X509_CRL(const_cast<X509_OBJECT*>(object))) {
      add_revoked(list, found.revoked);
    }
  }
  return found;
}

}  // namespace gnomon::daemon
