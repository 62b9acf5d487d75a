#pragma once

#include <Eigen/Core>

#include "engine/numbers/pair.h"

namespace stiefel {

/// The matrix of X ↦ XC + CᵀX on symmetric n × n matrices, factored.
class SymmetricSolve {
 public:
  using Index = Eigen::Index;

  explicit SymmetricSolve(Index n) : n_(n), lu_(size(n)) {}

  static constexpr std::size_t size(Index n) { return static_cast<std::size_t>(n * (n + 1) / 2); }
  /// Returns the place of element (a, b) of the upper triangle.
  static constexpr std::size_t at(Index a, Index b) {
    return static_cast<std::size_t>(a <= b ? b * (b + 1) / 2 + a : a * (a + 1) / 2 + b);
  }

  void factor(const Eigen::MatrixXd& C) {
    lu_.set_zero();
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a <= b; ++a)
        for (Index k = 0; k < n_; ++k) {
          lu_(at(a, b), at(a, k)) += C(k, b);
          lu_(at(a, b), at(k, b)) += C(k, a);
        }
    lu_.factor();
  }
  /// Replaces the upper triangle of a right-hand side by that of X.
  void solve(Pair* x) const { lu_.solve(x); }

  /// Sets X so that XC + CᵀX = s (R + Rᵀ), n × n, column by column.
  void solve(double s, const double* R, double* X) const {
    Pair upper[size(largest)];
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a <= b; ++a) upper[at(a, b)] = s * (R[a + n_ * b] + R[b + n_ * a]);
    lu_.solve(upper);
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a < n_; ++a) X[a + n_ * b] = upper[at(a, b)][0];
  }

  /// The largest n.
  static constexpr Index largest = 6;

 private:
  Index n_;
  PairLu lu_;
};

}  // namespace stiefel
