#pragma once

#include <complex>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Solves Y + RYR = G for an orthogonal N × N matrix R, which applies (I + R ⊗ Rᵀ)⁻¹ of [RB]
/// (3.15). Uses R = ZdZ†, |d_i| = 1, as in Lemma 3.10: Ŷ_ij = Ĝ_ij/(1 + d_id_j). The solution is
/// unique where no product d_id_j is −1, which holds on S. O(N³).
class SteinEquation {
 public:
  explicit SteinEquation(const Matrix<double>& R);
  Matrix<double> solve(const Matrix<double>& G) const;

 private:
  Matrix<std::complex<double>> Z_;
  Vector<std::complex<double>> d_;
};

}  // namespace stiefel
