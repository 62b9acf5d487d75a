#pragma once

#include <string_view>

#include "server/transport/descriptor.h"

namespace stiefel::server {

/// Answers "HTTP/1.1 503 REASON" and closes the connection. gRPC's clients take that for a server
/// that is not there for now: UNAVAILABLE, and they come back after growing pauses, whereas after
/// an HTTP/2 GOAWAY they come back at once, a thousand times a second. Never blocks: what the
/// socket does not take at once is dropped.
void refuse_connection(Descriptor connection, std::string_view reason);

}  // namespace stiefel::server
