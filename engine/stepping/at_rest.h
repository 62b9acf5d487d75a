#pragma once

namespace stiefel {

/// Whether a difference of matrices is only their rounding error: `norm` is its Frobenius norm,
/// `terms` that of the matrices, and the bound 16u·terms with u = 2⁻⁵³; where `terms` is 0, the
/// bound is 0. The momentum QᵀP − PᵀQ of a body at rest, for example, is computed as up to 2u‖P‖.
/// The drift of an invariant of such a state is divided by the value that the invariant has for a
/// momentum of size `terms`, so that it reads as a few u and not as 100 %.
inline bool is_rounding(double norm, double terms) { return norm <= 16 * 0x1p-53 * terms; }

}  // namespace stiefel
