#pragma once

#include <string>

namespace stiefel::server {

/// Returns the first bytes that a TLS client offering HTTP/2 sends, which a live server answers.
/// Empty if OpenSSL fails.
std::string client_hello();

}  // namespace stiefel::server
