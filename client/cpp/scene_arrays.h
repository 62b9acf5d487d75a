#pragma once

#include "client/cpp/assembly.h"
#include "stiefel/client/connection.h"

namespace stiefel::client {

/// All arrays of a session's resolved scene, each with its path as its name. Throws Error.
Fields scene_arrays(const Connection& connection, const std::string& session_id,
                    const Recreation& routing);

}  // namespace stiefel::client
