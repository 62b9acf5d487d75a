#pragma once

#include "server/transport/listener.h"

namespace stiefel::server {

/// listen_on and listen_fault for unix:PATH.
Listener listen_on_unix(const std::string& address);
std::optional<std::string> unix_fault(const std::string& address);

}  // namespace stiefel::server
