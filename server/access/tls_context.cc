#include "server/access/tls_context.h"

#include <algorithm>
#include <exception>
#include <new>

#include "server/access/served_certificates.h"

namespace stiefel::server {
namespace {

bool present(SSL* connection, const Certificates& own) {
  const std::vector<Certificate> chain = read_chain(own.chain);
  const Key key = read_key(own.key);
  return !chain.empty() && SSL_use_certificate(connection, chain.front().get()) == 1 &&
         SSL_use_PrivateKey(connection, key.get()) == 1 &&
         std::all_of(chain.begin() + 1, chain.end(), [&](const Certificate& one) {
           return SSL_add1_chain_cert(connection, one.get()) == 1;
         });
}

bool ask_for(SSL* connection, const std::string& authorities) {
  const std::unique_ptr<X509_STORE, Release<X509_STORE_free>> store(X509_STORE_new());
  for (const Certificate& one : read_chain(authorities))
    if (X509_STORE_add_cert(store.get(), one.get()) != 1 ||
        SSL_add_client_CA(connection, one.get()) != 1)
      return false;
  SSL_set_verify(connection, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  return SSL_set1_verify_cert_store(connection, store.get()) == 1;
}

/// Called by OpenSSL before it chooses a certificate; 0 ends the handshake.
int take_newest(SSL* connection, void* served) noexcept {
  try {
    const Certificates now = static_cast<const ServedCertificates*>(served)->current();
    return present(connection, now) &&
           (now.client_ca.empty() || ask_for(connection, now.client_ca));
  } catch (const std::exception&) {
    return 0;
  }
}

}  // namespace

TlsContext tls_context(const ServedCertificates& served) {
  TlsContext context(SSL_CTX_new(TLS_server_method()));
  if (!context || SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) != 1)
    throw std::bad_alloc();
  // A resumed session would keep the certificates of its first handshake.
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_options(context.get(), SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_cert_cb(context.get(), take_newest, const_cast<ServedCertificates*>(&served));
  return context;
}

}  // namespace stiefel::server
