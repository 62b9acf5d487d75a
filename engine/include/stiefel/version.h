#pragma once

#include <string>

namespace stiefel {

/// Everything that could change bits between two processes: version, compiler, flags, C library,
/// CPU features. Two processes with equal fingerprints compute the same states.
const std::string& build_fingerprint();

/// What measured times are times of: CPU and number of cores.
const std::string& machine();

}  // namespace stiefel
