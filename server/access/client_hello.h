#pragma once

#include <string>

namespace stiefel::server {

/// The first bytes of a TLS client that offers HTTP/2: a server that lives answers them. Empty
/// where OpenSSL fails.
std::string client_hello();

}  // namespace stiefel::server
