#pragma once

#include "stiefel/catalogue.h"

namespace stiefel {

/// The common data of rigid_body and moser_veselov: blocks, fields and invariants of (Q, M).
SystemInfo rigid_body_family();

/// A step of the rigid body in nanoseconds, roughly.
inline double rigid_body_cost(double N) { return N == 3 ? 300 : 1000 + 50 * N * N + 5 * N * N * N; }

}  // namespace stiefel
