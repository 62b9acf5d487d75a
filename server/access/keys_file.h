#pragma once

#include <memory>
#include <string>

#include "server/sessions/checkpoints/checkpoint_keys.h"

namespace stiefel::server {

/// Returns the keys in a file (checkpoint_keys.h); null if `file` is empty. Throws
/// std::runtime_error with the flag, the file and the rule that it breaks, never with a key.
std::shared_ptr<const CheckpointKeys> checkpoint_keys(const std::string& file);

}  // namespace stiefel::server
