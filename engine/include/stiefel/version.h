#pragma once

#include <string>

namespace stiefel {

/// Returns everything that could change the bits of a state between two processes: digest of the
/// engine's sources, versions of the libraries, compiler, its options, C library, CPU features. Two
/// processes with equal fingerprints compute the same states.
const std::string& build_fingerprint();

/// Returns the machine on which times are measured: CPU and number of cores.
const std::string& machine();

}  // namespace stiefel
