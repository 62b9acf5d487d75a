#pragma once

#include <string>

namespace stiefel::server {

/// PEM files; all empty: no TLS.
struct TlsFiles {
  std::string certificate;  ///< the server's, and the chain up to its authority
  std::string key;          ///< of the certificate
  std::string client_ca;    ///< authorities of the clients' certificates; empty: clients need none

  bool given() const { return !certificate.empty() || !key.empty() || !client_ca.empty(); }
};

/// Who may connect, who may call, and how both are known.
struct AccessOptions {
  /// For every address but Unix sockets.
  TlsFiles tls = {};
  /// A file of tokens (tokens.h); empty: every caller is the principal "".
  std::string tokens = {};
  /// A file of keys (checkpoint_keys.h); empty: a random key.
  std::string checkpoint_key = {};
  /// Allows addresses that other machines reach without TLS.
  bool insecure = false;
};

}  // namespace stiefel::server
