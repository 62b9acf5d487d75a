#pragma once

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// A seeded state on V(n, N): Λ between 1 and `spread`, a random frame Q, and S = Q̇Λ for a random
/// tangent Q̇ with ‖Q̇‖_F = 1. Q̇ is tangent to rounding in the Scalar.
template <class Scalar>
struct RandomFrame {
  Vector<Scalar> lambda;
  Matrix<Scalar> Q, S;

  RandomFrame(int n, int N, unsigned seed, double spread = 4);

  Matrix<Scalar> state() const;
};

// Compiled once, in random_frame.cc.
extern template struct RandomFrame<double>;
extern template struct RandomFrame<long double>;
extern template struct RandomFrame<Quad>;

}  // namespace stiefel::testing
