#include "server/access/client_hello.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <memory>

namespace stiefel::server {

std::string client_hello() {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  &SSL_CTX_free);
  if (!context) return {};
  const std::unique_ptr<SSL, decltype(&SSL_free)> connection(SSL_new(context.get()), &SSL_free);
  if (!connection) return {};
  BIO* const out = BIO_new(BIO_s_mem());
  SSL_set_bio(connection.get(), BIO_new(BIO_s_mem()), out);  // takes ownership of both
  constexpr unsigned char http2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(connection.get(), http2, sizeof http2);
  SSL_set_connect_state(connection.get());
  SSL_do_handshake(connection.get());  // stops to wait for the server's answer
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(out, &bytes);
  ERR_clear_error();
  return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : std::string();
}

}  // namespace stiefel::server
