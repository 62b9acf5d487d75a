#pragma once

namespace stiefel {

/// Whether a quantity of size `norm` is only the rounding error of a difference of matrices of size
/// `terms` (Frobenius norms). The momentum QᵀP − PᵀQ of a body at rest can be up to 2u‖P‖, u =
/// 2⁻⁵³, instead of 0. Its invariants are then measured against their values for a quantity of size
/// `terms`, so that a change reads as a few u and not as 100 %. For `terms` = 0 only the norm 0 is
/// at rest.
inline bool is_rounding(double norm, double terms) { return norm <= 16 * 0x1p-53 * terms; }

}  // namespace stiefel
