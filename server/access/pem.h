#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>
#include <string>
#include <vector>

namespace stiefel::server {

/// Gives an object of OpenSSL back.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const {
    release(object);
  }
};
using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;

/// OpenSSL keeps a queue of errors for each thread, of which gRPC would read those that others
/// leave. The destructor empties it.
struct CleanErrors {
  ~CleanErrors();
};

/// All certificates of a text in PEM, in their order; none if one of them cannot be read.
std::vector<Certificate> read_chain(const std::string& pem);

/// The private key of a text in PEM; null if there is none, or one with a passphrase.
Key read_key(const std::string& pem);

}  // namespace stiefel::server
