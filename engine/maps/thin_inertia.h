#pragma once

#include <memory>

#include "engine/linalg/double_word.h"
#include "engine/linalg/principal_moments_3.h"

namespace stiefel {

/// ModifiedSeries for rods. In 1/J_i = s/I_i + d the terms of order hᵏ are larger than their sum by
/// (I_max/I_min)^{k/2}: at order 10 a rod of 1 : 10³ loses twelve digits, one of 1 : 10⁹ all that
/// quadruple precision has. So they are summed in 512 bits, which is slow, but J is formed once a
/// motion.
class ThinInertia {
 public:
  /// Holds extended and quadruple precision.
  using Words = DoubleWord<long double>;

  ThinInertia(const Vector3<Words>& lambda, int order);

  /// J for the motion that passes through m, with the step h.
  PrincipalMoments3<Words> operator()(const Vector3<Words>& m, const Words& h) const;

 private:
  struct Series;
  std::shared_ptr<const Series> series_;
};

}  // namespace stiefel
