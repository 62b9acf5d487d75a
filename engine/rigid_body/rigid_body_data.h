#pragma once

#include "stiefel/catalogue.h"

namespace stiefel {

/// Returns the common data of rigid_body and moser_veselov: blocks, fields and invariants of (Q,
/// M).
SystemInfo rigid_body_family();

/// Returns the rough number of nanoseconds for a step of the rigid body.
inline double rigid_body_cost(double N) { return N == 3 ? 300 : 1000 + 50 * N * N + 5 * N * N * N; }

}  // namespace stiefel
