#pragma once

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
  using Numbers = Eigen::Map<const Vector<double>>;

  Anderson(Eigen::Index size, Eigen::Index depth);

  void restart() { seen_ = 0; }

  /// Remembers g and f of one x.
  void add(const Numbers& g, const Numbers& f);

  /// Sets x, which is the last g, to the next one.
  void mix(Eigen::Map<Vector<double>> x) const;

  /// Sets x to the next one from f of this x.
  void operator()(Vector<double>& x, const Vector<double>& f);

 private:
  static constexpr Eigen::Index most = 10;

  Eigen::Index depth_, seen_ = 0;
  Vector<double> g_, f_;
  Matrix<double> dg_, df_;
};

}  // namespace stiefel
