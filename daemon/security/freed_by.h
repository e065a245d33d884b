// Owners of a C library's objects, as OpenSSL's: std::unique_ptr<X509, FreedBy<X509_free>>.
#pragma once

namespace gnomon::daemon {

template <auto Free>
struct FreedBy {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};

}  // namespace gnomon::daemon
