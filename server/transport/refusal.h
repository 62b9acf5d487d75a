#pragma once

#include <string_view>

#include "server/transport/descriptor.h"

namespace stiefel::server {

/// Answers "HTTP/1.1 503 REASON" and closes the connection. gRPC's clients report that as
/// UNAVAILABLE and retry after growing pauses; after an HTTP/2 GOAWAY they would retry at once, a
/// thousand times a second. Never blocks: drops what the socket does not take at once.
void refuse_connection(Descriptor connection, std::string_view reason);

}  // namespace stiefel::server
