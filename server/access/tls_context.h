#pragma once

#include <openssl/ssl.h>

#include <memory>

#include "server/access/pem.h"

namespace stiefel::server {

class ServedCertificates;

using TlsContext = std::unique_ptr<SSL_CTX, Release<SSL_CTX_free>>;

/// Returns a context for a server's handshakes by OpenSSL: TLS 1.2 and 1.3, with the certificates
/// that `served` has at the time of the handshake. With --tls-client-ca the client must have a
/// certificate of one of these authorities. `served` must outlive the context and its connections.
/// Throws std::bad_alloc.
TlsContext tls_context(const ServedCertificates& served);

}  // namespace stiefel::server
