#pragma once

#include <Eigen/Core>

#include "engine/dense/decompositions.h"
#include "engine/numbers/pair.h"

namespace stiefel {

/// Solves XC + CᵀX = s (R + Rᵀ) for symmetric n × n matrices X: for small n by the matrix of the
/// equation on elements, else by the Schur form of C.
class SymmetricSolve {
 public:
  using Dense = Eigen::MatrixXd;
  using Index = Eigen::Index;

  explicit SymmetricSolve(Index n) : n_(n), lu_(n > largest ? 0 : at(0, n)), lyapunov_(n) {}

  void factor(const Dense& C) {
    if (n_ > largest) return lyapunov_.factor(C);
    lu_.set_zero();
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a <= b; ++a)
        for (Index k = 0; k < n_; ++k) {
          lu_(at(a, b), at(a, k)) += C(k, b);
          lu_(at(a, b), at(k, b)) += C(k, a);
        }
    lu_.factor();
  }

  void solve(double s, const Dense& R, Dense& X) {
    if (n_ > largest) {
      X = s * (R + R.transpose());
      return lyapunov_.solve(X, X);
    }
    Pair upper[largest * (largest + 1) / 2];
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a <= b; ++a) upper[at(a, b)] = s * (R(a, b) + R(b, a));
    lu_.solve(upper);
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a < n_; ++a) X(a, b) = upper[at(a, b)][0];
  }

 private:
  static constexpr Index largest = 6;

  /// Returns the place of element (a, b) of the upper triangle.
  static constexpr std::size_t at(Index a, Index b) {
    return static_cast<std::size_t>(a <= b ? b * (b + 1) / 2 + a : a * (a + 1) / 2 + b);
  }

  Index n_;
  PairLu lu_;
  Lyapunov<double> lyapunov_;
};

}  // namespace stiefel
