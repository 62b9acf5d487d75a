#pragma once

#include <vector>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Anderson's acceleration of the fixed-point iteration x ← g(x) (Anderson 1965; Walker and Ni
/// 2011),
///
///     x ← g − Σ c_i Δg_i,   c = argmin ‖f − Σ c_i Δf_i‖,   f = g(x) − x,
///
/// over the last `depth` ≤ 10 differences. It converges for many g that are not contractions. c is
/// from the normal equations of the Δf_i scaled to unit length. Allocates at construction only.
class Anderson {
 public:
  Anderson(Eigen::Index rows, Eigen::Index cols, Eigen::Index depth);

  void restart() { seen_ = 0; }

  /// The matrices for g and f of the next x; `keep` remembers them.
  Matrix<double>& g() { return g_[seen_ % g_.size()]; }
  Matrix<double>& f() { return f_[seen_ % f_.size()]; }
  void keep() { ++seen_; }

  /// Sets x, which is the g remembered last, to the next one.
  void mix(Matrix<double>& x);

  /// Sets x to the next one from f of this x.
  void operator()(Vector<double>& x, const Vector<double>& f);

 private:
  static constexpr Eigen::Index most = 10;

  std::size_t seen_ = 0;
  std::vector<Matrix<double>> g_, f_;  ///< of the last depth + 1 x
  Matrix<double> df_;                  ///< the Δf_i as columns
};

}  // namespace stiefel
