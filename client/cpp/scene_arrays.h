#pragma once

#include "client/cpp/assembly.h"
#include "stiefel/client/connection.h"

namespace stiefel::client {

/// Fetches all arrays of a session's resolved scene; the name of each is its path in the scene.
/// Begins anew after `handle` had to create the session again. Throws Error.
Fields scene_arrays(const Connection& connection, const std::string& session_id,
                    Recreation& handle);

}  // namespace stiefel::client
