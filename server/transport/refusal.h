#pragma once

#include <string_view>

#include "server/transport/descriptor.h"

namespace stiefel::server {

/// Tells a client, in HTTP/2, that it is not served and why, and closes the connection. Never
/// blocks: what the socket does not take at once is dropped.
void refuse_connection(Descriptor connection, std::string_view reason);

}  // namespace stiefel::server
