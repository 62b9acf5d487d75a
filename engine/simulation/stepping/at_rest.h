#pragma once

namespace stiefel {

/// Whether a quantity of size `norm` is nothing but the rounding of matrices of size `terms`, both
/// Frobenius norms, of which it is a difference: the momentum QᵀP − PᵀQ of a body at rest is seen
/// to be up to 2u‖P‖, u = 2⁻⁵³, in place of 0. What depends on it is then measured against what it
/// would be for a quantity of size `terms`, so that its change reads as a few u, not as 100 %.
/// Without terms only 0 is at rest.
inline bool is_rounding(double norm, double terms) { return norm <= 16 * 0x1p-53 * terms; }

}  // namespace stiefel
