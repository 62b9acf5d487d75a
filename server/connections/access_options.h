#pragma once

#include <string>

namespace stiefel::server {

/// Paths of PEM files; all empty means no TLS.
struct TlsFiles {
  std::string certificate;  ///< the server's certificate, and the chain up to its authority
  std::string key;          ///< the private key of the certificate
  std::string client_ca;    ///< authorities of the clients' certificates; empty: clients need none

  bool given() const { return !certificate.empty() || !key.empty() || !client_ca.empty(); }
};

/// Who may connect and who may call, and how the server knows.
struct AccessOptions {
  /// TLS for every address but Unix sockets.
  TlsFiles tls = {};
  /// A file of tokens (callers.h); empty means that every caller is the principal "".
  std::string tokens = {};
  /// Allows addresses without TLS that other machines can reach.
  bool insecure = false;
};

}  // namespace stiefel::server
