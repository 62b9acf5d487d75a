#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>
#include <string>
#include <vector>

namespace stiefel::server {

/// A deleter that calls OpenSSL's function `release`.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const {
    release(object);
  }
};
using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;

/// Empties OpenSSL's error queue of this thread when destroyed; gRPC would take errors left there
/// for its own.
struct CleanErrors {
  ~CleanErrors();
};

/// Returns all certificates of a PEM text in order; none if one of them cannot be read.
std::vector<Certificate> read_chain(const std::string& pem);

/// Returns the private key of a PEM text; null if there is none or it has a passphrase.
Key read_key(const std::string& pem);

}  // namespace stiefel::server
