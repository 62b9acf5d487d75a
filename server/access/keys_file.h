#pragma once

#include <memory>
#include <string>

#include "server/sessions/checkpoints/checkpoint_keys.h"

namespace stiefel::server {

/// The keys of a file (checkpoint_keys.h); null for no file. Throws std::runtime_error with the
/// flag, the file and the rule, and never shows a key.
std::shared_ptr<const CheckpointKeys> checkpoint_keys(const std::string& file);

}  // namespace stiefel::server
